// Makes random pairs of solids, detects their contacts, and judges them by exact predicates: no
// overlap deeper than the touch tolerance is missed, none is invented, and depths and normals of
// vertices are exact.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "fuzz/invariants.hpp"
#include "fuzz/pair_generator.hpp"
#include "fuzz/pair_judge.hpp"
#include "fuzz/player.hpp"
#include "fuzz/shrink.hpp"
#include "fuzz/solid_surface.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/reference_backends.hpp"

namespace pierce::fuzz {
namespace {

namespace fs = std::filesystem;

struct Options {
    std::uint64_t seed = 1;
    std::uint64_t first = 0;
    std::uint64_t pairs = 100'000;
    double seconds = 0;
    std::uint32_t meshes = 1000;
    std::uint32_t shown = 20;
    bool documented = false;
    std::string csv;
    std::string out;
    std::vector<std::string> replay;
};

constexpr std::array coverages = {Coverage::overlaps, Coverage::complete};

const char* name_of(Coverage coverage) {
    return coverage == Coverage::overlaps   ? "overlaps"
           : coverage == Coverage::complete ? "complete"
                                            : "vertices";
}

class Pairs {
public:
    explicit Pairs(const Options& options) : options_(options) {}

    int run() {
        const auto begin = std::chrono::steady_clock::now();
        const auto passed = [&] {
            return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        };
        PairGenerator generator(options_.seed, options_.meshes);
        std::uint64_t done = 0;
        for (; done < options_.pairs && (options_.seconds == 0 || passed() < options_.seconds);
             ++done) {
            const std::uint64_t number = options_.first + done;
            const SolidPair pair = generator.pair(number);
            for (std::size_t c = 0; c < coverages.size(); ++c) {
                Program program = pair.program;
                program.settings.coverage = coverages[c];
                // The backends take turns.
                const bool embree = (number / static_cast<std::uint64_t>(Placement::count) + c) % 2;
                judge(program, embree, fmt::format("seed {} pair {}", options_.seed, number),
                      pair.placement, fmt::format("pair_{}_{}", options_.seed, number));
            }
        }
        seconds_ = passed();
        report(done);
        if (!options_.csv.empty()) write_csv();
        return failed_ > 0 ? 1 : 0;
    }

    int replay() {
        for (const std::string& path : options_.replay) {
            std::ifstream file(path);
            const Program program = program_of({std::istreambuf_iterator<char>(file), {}});
            for (bool embree : {false, true}) judge(program, embree, path, Placement::anywhere, "");
        }
        return failed_ > 0 ? 1 : 0;
    }

private:
    void judge(const Program& program, bool embree, const std::string& what, Placement placement,
               const std::string& file) {
        PairCounts counts;
        const std::vector<Failure> failures = judged(program, embree, pool_, counts);
        counts_[{placement, program.settings.coverage}] += counts;
        if (failures.empty()) return;
        ++failed_;
        const Failure& first = failures.front();
        for (const Failure& f : failures) ++kinds_[f.kind];
        const bool is_new = std::uint64_t{options_.shown} > failed_ - 1 ||
                            kinds_[first.kind] <= options_.shown;
        if (!is_new) return;
        fmt::print("{}, {}, {}, {}: {}, {}{}\n", what, fuzz::name_of(placement),
                   name_of(program.settings.coverage), embree ? "Embree" : "reference", first.kind,
                   first.text,
                   failures.size() > 1 ? fmt::format(", and {} more", failures.size() - 1) : "");
        std::fflush(stdout);
        if (options_.out.empty() || file.empty()) return;
        fs::create_directories(options_.out);
        std::ofstream(fs::path(options_.out) /
                      fmt::format("{}_{}.json", file, name_of(program.settings.coverage)))
            << to_text(shrunk(program, [&](const Program& smaller) {
                   PairCounts ignored;
                   return smaller.settings.coverage == program.settings.coverage &&
                          smaller.settings.reproject && is_pair_of_solids(smaller) &&
                          std::ranges::any_of(
                              judged(smaller, embree, std::make_shared<MeshPool>(), ignored),
                              [&](const Failure& f) { return f.kind == first.kind; });
               }));
    }

    std::vector<Failure> judged(const Program& program, bool embree,
                                const std::shared_ptr<MeshPool>& pool, PairCounts& counts) {
        Player player([embree] { return embree ? embree_backend(1) : reference_backend(); },
                      program.settings, pool);
        Model model(program.settings);
        for (const Call& call : program.calls) {
            const Player::Outcome outcome = player.play(call);
            if (outcome.refused) throw std::runtime_error("refused: " + outcome.text);
            model.apply(call, player);
        }
        if (!options_.replay.empty())
            for (const Contact& c : player.world().contacts()) fmt::print("{}\n", to_text(c));
        return judge_pair(model, player.world().contacts(),
                          options_.documented ? Exact::documented : Exact::all, counts);
    }

    /// What shrinking may leave.
    static bool is_pair_of_solids(const Program& program) {
        Player player([] { return reference_backend(); }, program.settings);
        Model model(program.settings);
        bool detects = false;
        for (const Call& call : program.calls) {
            if (player.play(call).refused) return false;
            model.apply(call, player);
            detects = call.kind == Call::Kind::detect;
        }
        const auto is_proper = [](const SolidSurface& surface) {
            Box box;
            for (const Vec3d& p : surface.points) box.extend(p);
            return surface.is_proper(4 * constants::touch_tolerance * box.extent());
        };
        return detects && model.bodies().size() == 2 &&
               std::ranges::all_of(model.bodies(), [&](const ModelBody* body) {
                   const MeshData& mesh = model.mesh(*body);
                   SolidSurface rest{{}, mesh.triangles};
                   for (Vec3f p : mesh.positions) rest.points.push_back(to_double(p));
                   return body->finite && is_proper(rest) &&
                          is_proper({model.ends(*body), mesh.triangles});
               });
    }

    PairCounts sum(Coverage coverage) const {
        PairCounts all;
        for (const auto& [key, counts] : counts_)
            if (key.second == coverage) all += counts;
        return all;
    }

    void report(std::uint64_t done) const {
        fmt::print("seed {}, pairs {} to {}, {:.1f} s, {:.2f} ms a pair\n", options_.seed,
                   options_.first, options_.first + done, seconds_,
                   1e3 * seconds_ / static_cast<double>(std::max<std::uint64_t>(done, 1)));
        for (Coverage coverage : coverages) {
            const PairCounts c = sum(coverage);
            fmt::print(
                "{}: {} pairs, {} overlap, {} of these deeper than the touch tolerance, {} without "
                "a vertex\n"
                "  missed: {} deeper, {} deeper but thin, {} in the skin, {} undecided; {} of "
                "these without any contact; {} within the touch tolerance; {:.3g} ulp at most\n"
                "  invented: {}; {} nearer than the touch tolerance, {:.3g} ulp at most\n"
                "  edges to a ridge: {} contacts\n"
                "  vertices inside: {}, {} of these without a contact\n",
                name_of(coverage), c.pairs, c.overlapping, c.deep, c.without_vertex, c.missed,
                c.missed_thin, c.missed_skin, c.undecided, c.unseen, c.shallow, c.most_allowed,
                c.invented, c.near, c.most_apart, c.ridges, c.vertices_inside, c.vertices_missed);
            for (std::size_t of = 0; of < c.errors.size(); ++of)
                for (std::size_t k = 0; k < c.errors[of].size(); ++k) {
                    const EndingErrors& e = c.errors[of][k];
                    fmt::print(
                        "  {} {}: {} contacts, {} beyond 8 ulp, {} in a plane; at most {:.3g} ulp, "
                        "depth {:.3g} "
                        "ulp, normal {:.3g} rad\n",
                        of == 0 ? "vertices" : "edges", fuzz::name_of(static_cast<Ending>(k)),
                        e.contacts, e.beyond, e.in_plane, e.most, e.most_depth, e.most_angle);
                }
        }
        for (const auto& [kind, count] : kinds_) fmt::print("{} times: {}\n", count, kind);
        fmt::print("{} failed\n", failed_);
    }

    void write_csv() const {
        std::ofstream out(options_.csv);
        out << "placement,coverage,pairs,overlapping,deep,without_vertex,missed,missed_thin,missed_"
               "skin,"
               "undecided,unseen,shallow,most_allowed_ulp,invented,near,most_apart_ulp,edges_to_"
               "ridge,vertices_inside,vertices_missed";
        for (const char* of : {"vertices", "edges"})
            for (std::size_t k = 0; k < static_cast<std::size_t>(Ending::count); ++k)
                for (const char* what : {"contacts", "beyond", "in_plane", "most_ulp",
                                         "most_depth_ulp", "most_angle_rad"})
                    out << fmt::format(",{}_{}_{}", of, fuzz::name_of(static_cast<Ending>(k)),
                                       what);
        out << '\n';
        const auto row = [&](const char* placement, Coverage coverage, const PairCounts& c) {
            out << fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{:.4g},{},{},{:.4g},{},{},{}",
                               placement, name_of(coverage), c.pairs, c.overlapping, c.deep,
                               c.without_vertex, c.missed, c.missed_thin, c.missed_skin,
                               c.undecided, c.unseen, c.shallow, c.most_allowed, c.invented, c.near,
                               c.most_apart, c.ridges, c.vertices_inside, c.vertices_missed);
            for (const auto& of : c.errors)
                for (const EndingErrors& e : of)
                    out << fmt::format(",{},{},{},{:.4g},{:.4g},{:.4g}", e.contacts, e.beyond,
                                       e.in_plane, e.most, e.most_depth, e.most_angle);
            out << '\n';
        };
        for (const auto& [key, counts] : counts_) row(fuzz::name_of(key.first), key.second, counts);
        for (Coverage coverage : coverages) row("all", coverage, sum(coverage));
    }

    const Options& options_;
    std::shared_ptr<MeshPool> pool_ = std::make_shared<MeshPool>();
    std::map<std::pair<Placement, Coverage>, PairCounts> counts_;
    std::map<std::string, std::uint64_t> kinds_;
    std::uint64_t failed_ = 0;
    double seconds_ = 0;
};

}  // namespace
}  // namespace pierce::fuzz

int main(int argc, char** argv) {
    using namespace pierce::fuzz;
    CLI::App app{"Random pairs of solids, judged by exact predicates"};
    Options options;
    app.add_option("--seed", options.seed)->capture_default_str();
    app.add_option("--first", options.first, "the first pair's number")->capture_default_str();
    app.add_option("--pairs", options.pairs)->capture_default_str();
    app.add_option("--seconds", options.seconds, "stop after so long")->type_name("S");
    app.add_option("--meshes", options.meshes, "that pairs share")
        ->capture_default_str()
        ->check(CLI::Range(1u, 65536u));
    app.add_flag("--documented", options.documented,
                 "contacts that the docs say are not exact need not be");
    app.add_option("--shown", options.shown, "failures of a kind that are printed")
        ->capture_default_str();
    app.add_option("--csv", options.csv, "write the counts")->type_name("FILE");
    app.add_option("--out", options.out, "write the failures that are printed as programs")
        ->type_name("FOLDER");
    app.add_option("--replay", options.replay, "judge these programs instead")->type_name("FILE");
    CLI11_PARSE(app, argc, argv);
    try {
        Pairs pairs(options);
        return options.replay.empty() ? pairs.run() : pairs.replay();
    } catch (const std::exception& error) {
        fmt::print(stderr, "pierce_pairs: {}\n", error.what());
        return 2;
    }
}
