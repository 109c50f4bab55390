#include "pierce/bullet/sheet_projection.hpp"

#include <algorithm>

namespace pierce::bullet {

void SheetProjection::add_terms(const Point& point, double sign, Row& row) {
    if (point.nodes == nullptr) {
        row.given_end += sign * point.end;
        row.start += sign * point.start;
        if (point.body == nullptr) return;
        row.body = point.body;
        row.arm = point.end - point.body->center;
        row.sign = sign;
        if (!(point.body->inverse_mass > 0)) return;
        const Vec3d lever = cross(row.arm, row.out);
        row.compliance += point.body->inverse_mass +
                          dot(lever, point.body->inverse_inertia * lever);
        // About no axis does a body turn more easily than the sum of its principal inverse inertias
        // says.
        const Matrix3& inertia = point.body->inverse_inertia;
        row.slip_compliance += point.body->inverse_mass +
                               (inertia.row[0].x + inertia.row[1].y + inertia.row[2].z) *
                                   length_squared(row.arm);
        return;
    }
    for (int k = 0; k < 3; ++k) {
        if (point.weight[k] == 0) continue;
        const double weight = sign * point.weight[k];
        const double inverse_mass = point.nodes->inverse_mass[point.vertex[k]];
        row.start += weight * to_double(point.nodes->start[point.vertex[k]]);
        row.compliance += weight * weight * inverse_mass;
        row.slip_compliance += weight * weight * inverse_mass;
        if (inverse_mass > 0)
            terms_.push_back({point.nodes, point.vertex[k], weight});
        else
            row.given_end += weight * point.nodes->end[point.vertex[k]];
    }
}

void SheetProjection::add(const Point& source, const Point& target, Vec3d out, double thickness) {
    if (rows_.empty()) terms_.clear();
    Row row;
    row.out = out;
    row.first = static_cast<std::uint32_t>(terms_.size());
    add_terms(source, 1, row);
    add_terms(target, -1, row);
    row.last = static_cast<std::uint32_t>(terms_.size());
    if (!(row.compliance > 0)) {
        terms_.resize(row.first);
        return;
    }
    const double opened = dot(out, row.start) + settings_.recovery_share * thickness;
    row.gap = std::clamp(opened, settings_.least_share * thickness,
                         settings_.kept_share * thickness);
    rows_.push_back(row);
}

Vec3d SheetProjection::offset(const Row& row) const {
    Vec3d sum = row.given_end;
    for (std::uint32_t i = row.first; i < row.last; ++i)
        sum += terms_[i].weight * terms_[i].nodes->end[terms_[i].vertex];
    if (row.body != nullptr) sum += row.sign * row.body->way(row.arm);
    return sum;
}

void SheetProjection::move(const Row& row, Vec3d impulse) {
    for (std::uint32_t i = row.first; i < row.last; ++i) {
        const Term& t = terms_[i];
        t.nodes->end[t.vertex] += (t.weight * t.nodes->inverse_mass[t.vertex]) * impulse;
    }
    if (row.body == nullptr) return;
    const Vec3d mine = row.sign * impulse;
    row.body->impulse += mine;
    if (!(row.body->inverse_mass > 0)) return;
    row.body->shift += row.body->inverse_mass * mine;
    row.body->turn += row.body->inverse_inertia * cross(row.arm, mine);
}

void SheetProjection::solve(Row& row) {
    const double before = row.pushed;
    row.pushed = std::max(0.0, before + (row.gap - dot(row.out, offset(row))) / row.compliance);
    move(row, (row.pushed - before) * row.out);

    const Vec3d slide = offset(row) - row.start;
    const Vec3d last = row.dragged;
    row.dragged -= (1 / row.slip_compliance) * (slide - dot(slide, row.out) * row.out);
    const double most = settings_.friction * row.pushed, drag = length(row.dragged);
    if (drag > most) row.dragged = (most / drag) * row.dragged;
    move(row, row.dragged - last);
}

bool SheetProjection::project() {
    for (std::uint32_t sweep = 0; sweep < settings_.sweeps; ++sweep) {
        // Sweeps alternate in direction, so that a push goes through a stack of layers both ways.
        if (sweep % 2 == 0)
            for (std::size_t i = 0; i < rows_.size(); ++i) solve(rows_[i]);
        else
            for (std::size_t i = rows_.size(); i-- > 0;) solve(rows_[i]);
    }
    return !rows_.empty();
}

}  // namespace pierce::bullet
