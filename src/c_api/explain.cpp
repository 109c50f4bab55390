#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/contacts.hpp"
#include "c_api/versioned.hpp"
#include "c_api/world_state.hpp"
#include "pierce/c/queries.h"

namespace pierce::c {
namespace {

constexpr bool same(pierce_reason a, Reason b) { return a == static_cast<int>(b); }
static_assert(same(PIERCE_REASON_CONTACT, Reason::contact));
static_assert(same(PIERCE_REASON_EXCLUDED, Reason::excluded));
static_assert(same(PIERCE_REASON_FILTERED, Reason::filtered));
static_assert(same(PIERCE_REASON_BOTH_FIXED, Reason::both_fixed));
static_assert(same(PIERCE_REASON_BOXES_APART, Reason::boxes_apart));
static_assert(same(PIERCE_REASON_OPEN_TARGET, Reason::open_target));
static_assert(same(PIERCE_REASON_OUTSIDE_BOX, Reason::outside_box));
static_assert(same(PIERCE_REASON_OUTSIDE_SOLID, Reason::outside_solid));
static_assert(same(PIERCE_REASON_NO_DIRECTION, Reason::no_direction));
static_assert(same(PIERCE_REASON_ENTRY_FIRST, Reason::entry_first));
static_assert(same(PIERCE_REASON_NOTHING_AHEAD, Reason::nothing_ahead));
static_assert(same(PIERCE_REASON_NOT_INSIDE_OWN, Reason::not_inside_own));
static_assert(same(PIERCE_REASON_OWN_EXIT_FIRST, Reason::own_exit_first));
static_assert(same(PIERCE_REASON_BEYOND_RANGE, Reason::beyond_range));
static_assert(same(PIERCE_REASON_NOT_LOOKED_AT, Reason::not_looked_at));
static_assert(same(PIERCE_REASON_NOT_LOOKED_FOR, Reason::not_looked_for));
static_assert(same(PIERCE_REASON_APART, Reason::apart));
static_assert(same(PIERCE_REASON_CLOSE_AT_REST, Reason::close_at_rest));
static_assert(same(PIERCE_REASON_BESIDE, Reason::beside));
static_assert(same(PIERCE_REASON_NO_TRIANGLE_NAMES_IT, Reason::no_triangle_names_it));
static_assert(same(PIERCE_REASON_UNEXPLAINED, Reason::unexplained));
static_assert(PIERCE_CERTIFICATE_NONE == static_cast<int>(Certificate::none) &&
              PIERCE_CERTIFICATE_PATCH == static_cast<int>(Certificate::patch) &&
              PIERCE_CERTIFICATE_PATCH_REST == static_cast<int>(Certificate::patch_rest) &&
              PIERCE_CERTIFICATE_VERTEX == static_cast<int>(Certificate::vertex));

}  // namespace
}  // namespace pierce::c

using namespace pierce::c;

pierce_status pierce_explain(pierce_world* world, pierce_body_id body, pierce_body_id other,
                             uint32_t vertex, pierce_explanation* explanation) {
    return guarded([&] {
        auto& inner = world_of(world);
        check_struct(explanation, "explanation");
        const auto answer = inner.explain(body_handle(body), body_handle(other), vertex);
        world->explanation = {answer, answer.text()};
        const pierce::Explanation& why = world->explanation.answer;
        write_struct(
            pierce_explanation{.struct_size = sizeof(pierce_explanation),
                               .text = world->explanation.text.c_str(),
                               .contact = why.contact ? record(&*why.contact) : nullptr,
                               .distance = why.distance,
                               .t = why.t,
                               .own_exit = why.own_exit,
                               .certificate_left = why.certificate.left,
                               .certificate = static_cast<std::uint32_t>(why.certificate.kind),
                               .reason = static_cast<std::uint32_t>(why.reason),
                               .triangle = why.triangle},
            explanation);
    });
}
