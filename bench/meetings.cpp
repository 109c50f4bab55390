// Meetings of two layers of cloth that shake: what decides each candidate, and how long it takes.
// Prints CSV.
//   pierce_meetings [cells a side]
// Candidates are a vertex and a face, or two edges, of different layers whose boxes over the whole
// step overlap. "axis", "start" and "end" are the shares that an axis and the directions between
// the closest points at the start and at the end prove apart; "apart" and "meet" are left for the
// search, which takes "advances" for one that meets.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "core/geometry/continuous.hpp"
#include "pierce/box.hpp"

namespace {

using namespace pierce;
using continuous::Corners;

struct Candidate {
    MovingPoint corner[4];
};

struct Layers {
    const char* name;
    double apart, shake, approach, rough, together;  ///< [edge length]
};

/// A vertex, an edge or a face of a layer.
struct Element {
    std::vector<MovingPoint> corners;
    int column, row;
    Box box;
};

/// A layer's elements with so many corners.
std::vector<Element> elements(int cells, std::size_t corners, double height, double rise,
                              const Layers& layers, std::uint32_t seed) {
    std::mt19937 engine(seed);
    const auto within = [&](double half) {
        return std::uniform_real_distribution<double>(-half, half)(engine);
    };
    std::vector<MovingPoint> grid;
    for (int i = 0; i <= cells; ++i)
        for (int j = 0; j <= cells; ++j) {
            const Vec3d rest{i + 0.37 * seed, j + 0.21 * seed,
                             height + 0.8 * std::sin(0.2 * i) * std::cos(0.15 * j)};
            const Vec3d start = rest + Vec3d{within(layers.rough), within(layers.rough),
                                             0.3 * within(layers.rough)};
            const Vec3d by{within(layers.shake) + layers.together, within(layers.shake),
                           within(layers.shake) + rise};
            grid.push_back({to_double(to_float(start)), to_double(to_float(start + by))});
        }
    std::vector<Element> result;
    const auto add = [&](int i, int j, std::initializer_list<int> offsets) {
        if (offsets.size() != corners) return;
        Element element{{}, i, j, {}};
        for (int offset : offsets) {
            const int x = i + offset / 2, y = j + offset % 2;
            if (x > cells || y > cells) return;
            element.corners.push_back(grid[static_cast<std::size_t>(x * (cells + 1) + y)]);
            element.box.extend(element.corners.back().start);
            element.box.extend(element.corners.back().end);
        }
        result.push_back(element);
    };
    for (int i = 0; i <= cells; ++i)
        for (int j = 0; j <= cells; ++j) {
            add(i, j, {0});
            add(i, j, {0, 1});
            add(i, j, {0, 2});
            add(i, j, {0, 3});
            add(i, j, {0, 2, 3});
            add(i, j, {0, 3, 1});
        }
    return result;
}

std::vector<Candidate> candidates(int cells, std::size_t first, std::size_t second,
                                  const Layers& layers) {
    const auto low = elements(cells, first, 0, layers.approach / 2, layers, 0);
    const auto high = elements(cells, second, layers.apart, -layers.approach / 2, layers, 1);
    std::vector<std::vector<const Element*>> at(
        static_cast<std::size_t>((cells + 1) * (cells + 1)));
    for (const Element& e : high)
        at[static_cast<std::size_t>(e.column * (cells + 1) + e.row)].push_back(&e);
    std::vector<Candidate> result;
    for (const Element& a : low)
        for (int i = std::max(a.column - 4, 0); i <= std::min(a.column + 4, cells); ++i)
            for (int j = std::max(a.row - 4, 0); j <= std::min(a.row + 4, cells); ++j)
                for (const Element* b : at[static_cast<std::size_t>(i * (cells + 1) + j)]) {
                    if (!overlap(a.box, b->box)) continue;
                    Candidate c;
                    std::copy(b->corners.begin(), b->corners.end(),
                              std::copy(a.corners.begin(), a.corners.end(), c.corner));
                    result.push_back(c);
                }
    return result;
}

/// Nanoseconds a candidate: the best of five runs.
template <class Features>
double time_of(const std::vector<Candidate>& list) {
    if (list.empty()) return 0;
    double best = 1e30;
    volatile std::size_t sink = 0;
    for (int run = 0; run < 5; ++run) {
        const auto begin = std::chrono::steady_clock::now();
        std::size_t meetings = 0;
        for (const auto& [c] : list) {
            Impact impact;
            meetings += continuous::Question<Features>(c[0], c[1], c[2], c[3]).meets(impact);
        }
        sink = meetings;
        const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() -
                                                              begin;
        best = std::min(best, took.count() / static_cast<double>(list.size()));
    }
    static_cast<void>(sink);
    return best;
}

template <class Features>
void measure(const char* kind, const Layers& layers, const std::vector<Candidate>& list) {
    constexpr int firsts = Features::firsts;
    enum { axis, start, end, apart, meet, all };
    std::vector<Candidate> decided[all];
    int advances = 0, most = 0;
    for (const Candidate& candidate : list) {
        const MovingPoint* c = candidate.corner;
        Corners from, to;
        continuous::relative_corners(c[0], c[1], c[2], c[3], from, to);
        const double size = std::max(separating::size_of(from), separating::size_of(to));
        const auto separates = [&](const Corners& now, const Corners& then) {
            const Vec3d n = Features::difference(now, Features::closest(now));
            return separating::separated_until<firsts>(now, then, 0, n, size) > 1;
        };
        int by = axis;
        if (!separating::axis_separates<firsts>(from, to, size)) {
            by = separates(from, to) ? start : separates(to, from) ? end : apart;
            if (by == apart) {
                continuous::Search<Features> search(from, to, size);
                Impact impact;
                if (search.run(impact)) {
                    by = meet;
                    advances += search.advances();
                }
                most = std::max(most, search.advances());
            }
        }
        decided[by].push_back(candidate);
    }
    std::printf("%s,%s,%zu", layers.name, kind, list.size());
    for (const auto& part : decided)
        std::printf(",%.4f", static_cast<double>(part.size()) /
                                 static_cast<double>(std::max<std::size_t>(list.size(), 1)));
    std::printf(",%.1f,%d,%.0f",
                advances / std::max(1.0, static_cast<double>(decided[meet].size())), most,
                time_of<Features>(list));
    for (const auto& part : decided) std::printf(",%.0f", time_of<Features>(part));
    std::puts("");
}

}  // namespace

int main(int argc, char** argv) {
    const int cells = argc > 1 ? std::atoi(argv[1]) : 100;
    std::puts(
        "layers,kind,candidates,axis,start,end,apart,meet,advances,most advances,ns,ns axis,ns "
        "start,ns end,ns apart,ns "
        "meet");
    for (const Layers& layers : {Layers{"approaching", 0.3, 0.1, 0.1, 0.1, 0},
                                 Layers{"through each other", 0.1, 0.2, 0.2, 0.1, 0},
                                 Layers{"falling together", 0.3, 0.1, 0, 0.1, 1},
                                 Layers{"resting", 0.05, 0.01, 0, 0, 0}}) {
        measure<continuous::VertexAndFace>("vertex and face", layers,
                                           candidates(cells, 1, 3, layers));
        measure<continuous::TwoEdges>("edges", layers, candidates(cells, 2, 2, layers));
    }
}
