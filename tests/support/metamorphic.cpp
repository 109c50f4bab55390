#include "support/metamorphic.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "support/random.hpp"

namespace pierce::test {
namespace {

void shuffle(MeshData& mesh, std::uint32_t seed) {
    Random random(seed);
    const auto order_of = [&](std::size_t count) {
        std::vector<std::uint32_t> order(count);
        std::iota(order.begin(), order.end(), 0u);
        for (std::size_t i = count; i > 1; --i)
            std::swap(order[i - 1],
                      order[static_cast<std::size_t>(random.integer(0, static_cast<int>(i) - 1))]);
        return order;
    };
    const std::vector<std::uint32_t> to = order_of(mesh.positions.size()),
                                     from = order_of(mesh.triangles.size());
    MeshData shuffled = mesh;
    for (std::size_t v = 0; v < to.size(); ++v) shuffled.positions[to[v]] = mesh.positions[v];
    for (std::size_t t = 0; t < from.size(); ++t) {
        const Triangle& triangle = mesh.triangles[from[t]];
        const int first = random.integer(0, 2);
        for (int k = 0; k < 3; ++k)
            shuffled.triangles[t].vertex[k] = to[triangle.vertex[(first + k) % 3]];
    }
    mesh = std::move(shuffled);
}

Change named(std::string name) {
    Change change;
    change.name = std::move(name);
    return change;
}

std::vector<Change> symmetries() {
    std::vector<Change> all;
    std::array<int, 3> axis = {0, 1, 2};
    do
        for (int signs = 0; signs < 8; ++signs) {
            Change change;
            change.axis = axis;
            change.sign = {signs & 1 ? -1.0 : 1.0, signs & 2 ? -1.0 : 1.0, signs & 4 ? -1.0 : 1.0};
            for (int k = 0; k < 3; ++k)
                change.name += (change.sign[k] < 0 ? "-" : "+") + std::string(1, "xyz"[axis[k]]);
            all.push_back(change);
        }
    while (std::ranges::next_permutation(axis).found);
    return all;
}

}  // namespace

Vec3d Change::direction(Vec3d v) const {
    return {sign.x * v[axis[0]], sign.y * v[axis[1]], sign.z * v[axis[2]]};
}

Vec3d Change::direction_back(Vec3d v) const {
    Vec3d back;
    for (int k = 0; k < 3; ++k) back[axis[k]] = sign[k] * v[k];
    return back;
}

std::optional<MeshData> Change::mesh(const MeshData& mesh) const {
    MeshData changed = mesh;
    const Vec3d by = by_pose ? Vec3d{} : offset;
    for (Vec3f& p : changed.positions) {
        const Vec3d before = scale * direction(to_double(p)), after = before + by;
        p = to_float(after);
        if (to_double(p) != after || after - by != before) return std::nullopt;
    }
    const bool even = (axis[1] - axis[0] + 3) % 3 == 1;
    if (even != (sign.x * sign.y * sign.z > 0))
        for (Triangle& t : changed.triangles) std::swap(t.vertex[1], t.vertex[2]);
    if (shuffle_seed != 0) shuffle(changed, shuffle_seed);
    return changed;
}

std::vector<Change> changes() {
    std::vector<Change> all = symmetries();
    const std::size_t symmetric = all.size();
    for (int k = -20; k <= 20; k += k > -4 && k < 4 ? 1 : 4) {
        Change change = named("scale 2^" + std::to_string(k));
        change.scale = std::ldexp(1.0, k);
        all.push_back(change);
    }
    for (int k = 0; k <= 22; ++k)
        for (bool by_pose : {false, true}) {
            const double by = std::ldexp(1.0, k);
            Change change = named("offset 2^" + std::to_string(k) + (by_pose ? " by pose" : ""));
            change.offset = k % 2 == 0 ? Vec3d{by, by, by} : Vec3d{0, -by, 0};
            change.by_pose = by_pose;
            all.push_back(change);
        }
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        Change change = named("shuffle " + std::to_string(seed));
        change.shuffle_seed = seed;
        all.push_back(change);
    }
    Change swapped = named("swapped"), deforming = named("deforming");
    swapped.swapped = true;
    deforming.deforming = true;
    all.push_back(swapped);
    all.push_back(deforming);
    for (std::uint32_t i = 0; i < 12; ++i) {
        Change change = all[(7 * i + 3) % symmetric];
        change.name = "everything " + std::to_string(i) + ", " + change.name;
        change.scale = std::ldexp(1.0, static_cast<int>(3 * i) - 18);
        change.offset = std::ldexp(1.0, static_cast<int>(2 * i) - 2) * Vec3d{1, -1, 1};
        change.by_pose = i % 4 != 3;
        change.shuffle_seed = 100 + i;
        change.swapped = i % 2 == 1;
        change.deforming = i % 4 == 3;
        all.push_back(change);
    }
    return all;
}

}  // namespace pierce::test
