#include "app/reports/accuracy/hard_case_table.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "app/measure/compare.hpp"
#include "app/output/plot.hpp"
#include "app/output/progress.hpp"
#include "pierce/box.hpp"
#include "pierce/error.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/measure/ray_probe.hpp"
#include "scenes/named/hard_cases.hpp"

namespace pierce::app {
namespace {

using scenes::HardBodies;
using scenes::HardCase;
using scenes::HardRay;
using scenes::Meets;

constexpr const char* methods[] = {"full",        "overlaps", "complete",
                                   "reprojected", "gjk-hull", "gimpact"};
constexpr const char* not_asked = "-";
constexpr double none = -1;  // in numbers: no contact, nothing met

enum class Verdict { right, other_depth, wrong };

std::string marked(Verdict verdict, const std::string& answer) {
    switch (verdict) {
        case Verdict::right:
            return "✓ " + answer;
        case Verdict::other_depth:
            return "≈ " + answer;
        case Verdict::wrong:
            return "**✗ " + answer + "**";
    }
    return answer;
}

/// How often a method was asked, and how often it was right.
struct Score {
    int asked = 0, right = 0, other_depth = 0, wrong = 0;

    void add(Verdict verdict) {
        ++asked;
        right += verdict == Verdict::right;
        other_depth += verdict == Verdict::other_depth;
        wrong += verdict == Verdict::wrong;
    }
};

std::string depth_text(double depth) {
    if (depth < 0) return "no contact";
    return depth == 0 ? "touching" : fmt::format("{:.5g}", depth);
}

/// Where positions are rounded, depths are.
double rounding_of(const HardBodies& bodies) {
    Box box;
    for (const MeshData* mesh : {&bodies.a, &bodies.b})
        for (Vec3f p : mesh->positions) box.extend(to_double(p));
    return constants::touch_tolerance * box.extent();
}

/// The deepest contact, or none.
double answer_of(const HardBodies& bodies, const ComparedMethod& method) {
    const scenes::SceneSetup scene{
        "hard case",
        {{"first", bodies.a, {}}, {"second", bodies.b, {}}},
        {{"first", 0, Motion::rigid, {}, false}, {"second", 1, Motion::rigid, {}, false}}};
    const auto detector = scenes::make_detector(scene, method.method,
                                                {"embree", 1, method.settings});
    detector->detect();
    double deepest = none;
    for (const scenes::MethodContact& c : detector->contacts())
        deepest = std::max(deepest, c.depth);
    return deepest;
}

Verdict judge(const HardBodies& bodies, double answer) {
    if ((answer < 0) != (bodies.parting < 0)) return Verdict::wrong;
    if (answer < 0 || std::abs(answer - bodies.parting) <= rounding_of(bodies))
        return Verdict::right;
    return Verdict::other_depth;
}

std::string ray_text(Meets meets, double t) {
    switch (meets) {
        case Meets::nothing:
            return "nothing";
        case Meets::entry:
            return fmt::format("entry at {:.4g}", t);
        case Meets::exit:
            return fmt::format("exit at {:.4g}", t);
        case Meets::touching:
            return "touching";
    }
    return {};
}

double number_of(Meets meets, double t) { return meets == Meets::nothing ? none : t; }

}  // namespace

void hard_case_table(Page& page) {
    Table table{{"case", "question", "exact", "ray"}, {}};
    std::string head = "| | case | exact answer | a ray |", line = "|---|---|---|---|", notes;
    for (const char* name : methods) {
        table.names.emplace_back(name);
        head += fmt::format(" {} |", name);
        line += "---|";
    }
    page.line("{}\n{}", head, line);
    std::string row;
    const auto add_cell = [&](const std::string& text, double number) {
        row += fmt::format(" {} |", text);
        table.rows.back().push_back(number);
    };
    std::map<std::string, Score> scores;
    scenes::RayProbe probe(scenes::make_backend({"embree", 1, {}}));
    const std::vector<HardCase> cases = scenes::hard_cases();
    Progress progress("hard cases", static_cast<std::uint32_t>(cases.size()));
    std::uint32_t done = 0;
    for (const HardCase& hard : cases) {
        double question = 0;
        const auto begin_row = [&](const std::string& situation) {
            row = fmt::format("| {} | {}{}{} |", hard.number, hard.name,
                              situation.empty() ? "" : ", ", situation);
            table.rows.push_back({static_cast<double>(hard.number), ++question});
        };
        for (const HardRay& ray : hard.rays) {
            const scenes::Met met = probe.meet(ray.mesh, ray.origin, ray.direction);
            const Verdict verdict = ray.differs || met.how != ray.meets ? Verdict::wrong
                                                                        : Verdict::right;
            scores["a ray"].add(verdict);
            begin_row("");
            add_cell(ray.differs ? "see below" : ray_text(ray.meets, ray.t),
                     ray.differs ? NAN : number_of(ray.meets, ray.t));
            add_cell(marked(verdict, ray_text(met.how, met.t)), number_of(met.how, met.t));
            for (std::size_t m = 0; m < std::size(methods); ++m) add_cell(not_asked, NAN);
            page.line("{}", row);
        }
        for (const HardBodies& bodies : hard.bodies) {
            begin_row(bodies.situation);
            add_cell(depth_text(bodies.parting), std::max(bodies.parting, none));
            add_cell(not_asked, NAN);
            for (const char* name : methods) {
                try {
                    const double answer = answer_of(bodies, compared_method_named(name));
                    const Verdict verdict = judge(bodies, answer);
                    scores[name].add(verdict);
                    add_cell(marked(verdict, depth_text(answer)), answer);
                } catch (const InputError&) {  // the method cannot serve these bodies
                    add_cell(not_asked, NAN);
                }
            }
            page.line("{}", row);
        }
        if (!hard.differs.empty())
            notes += fmt::format("* {} {}: {}.\n", hard.number, hard.name, hard.differs);
        progress.show(++done);
    }
    page.line(
        "\n| | asked | right | in contact, at another depth | wrong |\n|---|---|---|---|---|");
    for (const auto& [name, score] : scores)
        page.line("| {} | {} | {} | {} | {} |", name, score.asked, score.right, score.other_depth,
                  score.wrong);
    page.line("\nWhere Pierce's rules answer something else than the exact answer:\n\n{}", notes);
    page.csv(table, "hard_cases");
}

}  // namespace pierce::app
