#include "c_api/contacts.hpp"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/versioned.hpp"
#include "c_api/world_state.hpp"
#include "pierce/contact_changes.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/contact_reduction.hpp"

struct pierce_kept_contacts {
    pierce::KeptContacts contacts;
};

namespace pierce::c {
namespace {

pierce_contact_list list_of(std::span<const Contact> contacts) {
    return {record(contacts.data()), contacts.size(), sizeof(Contact)};
}

}  // namespace

static_assert(PIERCE_FOUND_SEPARATION == static_cast<int>(Found::separation) &&
              PIERCE_FOUND_TANGLED == static_cast<int>(Found::tangled) &&
              PIERCE_FOUND_REMEMBERED == static_cast<int>(Found::remembered) &&
              PIERCE_FOUND_CROSSING == static_cast<int>(Found::crossing) &&
              PIERCE_FOUND_NEAR == static_cast<int>(Found::near) &&
              PIERCE_FOUND_SELF == static_cast<int>(Found::self) &&
              PIERCE_FOUND_PREDICTION == static_cast<int>(Found::prediction) &&
              PIERCE_FOUND_WALK == static_cast<int>(Found::walk) &&
              PIERCE_FOUND_FULL == static_cast<int>(Found::full));
static_assert(PIERCE_NO_VERTEX == no_vertex && PIERCE_NO_TRIANGLE == no_triangle);

GivenContacts::GivenContacts(const pierce_contact_list* given, const char* name) {
    required(given, name);
    const auto records = list(given->contacts, given->count, name);
    if (records.empty()) return;
    if (given->stride < sizeof(Contact))
        throw InputError(std::string(name) + " has a stride of " + std::to_string(given->stride) +
                         " bytes, which is less than a contact");
    const bool aligned = reinterpret_cast<std::uintptr_t>(given->contacts) % alignof(Contact) == 0;
    if (aligned && given->stride == sizeof(Contact)) {
        contacts_ = {reinterpret_cast<const Contact*>(given->contacts), given->count};
        return;
    }
    copy_.resize(given->count);
    for (std::size_t i = 0; i < given->count; ++i)
        std::memcpy(static_cast<void*>(&copy_[i]), pierce_contact_at(given, i), sizeof(Contact));
    contacts_ = copy_;
}

void write_translation(const std::optional<Parting>& parting, pierce_translation* out) {
    pierce_translation result{};
    if (parting) {
        copy_to(result.direction, parting->direction);
        result.depth = parting->depth;
        result.exists = 1;
    }
    write_struct(result, out);
}

}  // namespace pierce::c

using namespace pierce::c;

pierce_status pierce_contacts(const pierce_world* world, pierce_contact_list* list) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(list, "list");
        *list = list_of(inner.contacts());
    });
}

pierce_status pierce_keep_contacts(pierce_world* world, pierce_kept_contacts** kept,
                                   pierce_contact_list* list) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(kept, "kept");
        required(list, "list");
        pierce::KeptContacts contacts = inner.keep_contacts();
        const pierce_contact_list all = list_of(contacts.all());
        *kept = new pierce_kept_contacts{std::move(contacts)};
        *list = all;
    });
}

void pierce_release_contacts(pierce_kept_contacts* kept) { delete kept; }

pierce_status pierce_contact_feature(const pierce_contact* contact, uint64_t* feature) {
    return guarded([&] {
        required(contact, "contact");
        required(feature, "feature");
        pierce::Contact copy;
        std::memcpy(static_cast<void*>(&copy), contact, sizeof copy);
        *feature = copy.feature();
    });
}

pierce_status pierce_contact_hash(const pierce_contact_list* list, uint64_t* hash) {
    return guarded([&] {
        required(hash, "hash");
        *hash = pierce::contact_hash(GivenContacts(list, "list").span());
    });
}

pierce_status pierce_contact_changes(const pierce_contact_list* earlier,
                                     const pierce_contact_list* later, uint32_t* began,
                                     size_t* began_count, uint32_t* stayed, size_t* stayed_count,
                                     uint32_t* ended, size_t* ended_count) {
    return guarded([&] {
        const GivenContacts before(earlier, "earlier"), after(later, "later");
        const auto changes = pierce::contact_changes(before.span(), after.span());
        const auto give = [](const std::vector<std::uint32_t>& from, std::uint32_t* to,
                             std::size_t* count) {
            if (to != nullptr) std::ranges::copy(from, to);
            if (count != nullptr) *count = from.size();
        };
        give(changes.began, began, began_count);
        give(changes.stayed, stayed, stayed_count);
        give(changes.ended, ended, ended_count);
    });
}

pierce_status pierce_reduce(const pierce_contact_list* list, uint32_t most_per_pair,
                            pierce_reduced_contact* reduced, size_t* reduced_count) {
    return guarded([&] {
        required(reduced_count, "reduced_count");
        const GivenContacts contacts(list, "list");
        if (!contacts.span().empty()) required(reduced, "reduced");
        const auto kept = pierce::reduce(contacts.span(), most_per_pair);
        std::ranges::transform(kept, reduced, [](const pierce::ReducedContact& c) {
            return pierce_reduced_contact{c.contact, 0, c.weight};
        });
        *reduced_count = kept.size();
    });
}

pierce_status pierce_least_translation(const pierce_contact_list* list,
                                       pierce_translation* translation) {
    return guarded([&] {
        check_struct(translation, "translation");
        write_translation(pierce::least_translation(GivenContacts(list, "list").span()),
                          translation);
    });
}
