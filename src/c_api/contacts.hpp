#pragma once

#include <bit>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "pierce/c/contact.h"
#include "pierce/contact.hpp"
#include "pierce/parting.hpp"

namespace pierce::c {

// A contact crosses the border as it is: the two records have one layout.
#define PIERCE_SAME_PLACE(member)                                                 \
    static_assert(offsetof(pierce_contact, member) == offsetof(Contact, member)); \
    static_assert(sizeof(pierce_contact::member) == sizeof(Contact::member))
PIERCE_SAME_PLACE(a);
PIERCE_SAME_PLACE(b);
PIERCE_SAME_PLACE(source);
PIERCE_SAME_PLACE(grazing);
PIERCE_SAME_PLACE(found);
PIERCE_SAME_PLACE(reprojected);
PIERCE_SAME_PLACE(of_sheet);
PIERCE_SAME_PLACE(unknown_side);
PIERCE_SAME_PLACE(padding_a);
PIERCE_SAME_PLACE(vertex);
PIERCE_SAME_PLACE(edge_end);
PIERCE_SAME_PLACE(edge);
PIERCE_SAME_PLACE(chord);
PIERCE_SAME_PLACE(other_edge);
PIERCE_SAME_PLACE(triangle);
PIERCE_SAME_PLACE(age);
PIERCE_SAME_PLACE(padding_b);
PIERCE_SAME_PLACE(along);
PIERCE_SAME_PLACE(time);
PIERCE_SAME_PLACE(distance);
PIERCE_SAME_PLACE(barycentric);
PIERCE_SAME_PLACE(point_a);
PIERCE_SAME_PLACE(point_b);
PIERCE_SAME_PLACE(normal);
PIERCE_SAME_PLACE(face_normal);
PIERCE_SAME_PLACE(padding_c);
#undef PIERCE_SAME_PLACE
static_assert(sizeof(pierce_contact) == sizeof(Contact));
// A handle's index is the lower half of its number.
static_assert(std::endian::native == std::endian::little);

inline const pierce_contact* record(const Contact* contact) {
    return reinterpret_cast<const pierce_contact*>(contact);
}

/// A caller's list of contacts: as it lies there, or copied where its records are larger than ours
/// or not aligned.
class GivenContacts {
public:
    /// Throws InputError for a list or records that are null, and for a stride below a record.
    GivenContacts(const pierce_contact_list* list, const char* name);
    GivenContacts(const GivenContacts&) = delete;
    GivenContacts& operator=(const GivenContacts&) = delete;

    std::span<const Contact> span() const { return contacts_; }

private:
    std::vector<Contact> copy_;
    std::span<const Contact> contacts_;
};

/// Fills a caller's struct, whose size check_struct() has checked.
void write_translation(const std::optional<Parting>& parting, pierce_translation* out);

}  // namespace pierce::c
