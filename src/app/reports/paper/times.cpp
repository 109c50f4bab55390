#include <algorithm>

#include "app/reports/paper/modes.hpp"
#include "app/reports/paper/sections.hpp"

namespace pierce::app {

using scenes::ContactError;

namespace {

/// Steps between full passes that predictions make do with.
constexpr std::uint32_t seldom = 2 * constants::full_every;

}  // namespace

void tables_2_and_3(std::span<const Pile> piles, Page& page) {
    struct Figures {
        const char* scene;
        const char* full;
        const char* iterative;
        const char* predictive;
    };
    constexpr Figures paper[] = {{"tori", "56.7", "36.2", "37.2"},
                                 {"bunnies", "129.2", "116.3", "118.6"}};
    Table table{
        {"scene", "half", "off_ms", "paper_ms", "predict_ms", "predict_seldom_ms", "certified_ms"},
        {}};

    page.line("\n## Tables 2 and 3: iterative and predictive rays\n");
    page.line(
        "Narrow phase per frame: medians over each half of the motion, one thread, all modes on "
        "the same frames in turn.");
    page.line(
        "*Off* traces every vertex that is not culled; *paper* walks from the last hits, with a "
        "full pass every {} steps;\n"
        "*certified* leaves out what is proved to be needless and has the contacts of *off*, all "
        "of them. The paper:\n"
        "off / paper 1.57 (tori), 1.11 (bunnies); prediction costs 2.8 %, 2.0 %.\n",
        constants::full_every);
    page.line(
        "| scene, half | off [ms] | paper [ms] | + prediction [ms] | + prediction, full pass every "
        "{} [ms] | certified [ms] "
        "| "
        "off / paper | prediction costs | and finds more contacts | every {} it costs | off / "
        "certified |",
        seldom, seldom);
    page.line("|---|---|---|---|---|---|---|---|---|---|---|");
    std::string errors =
        "\n| scene | mode | missed contacts | of the depth | missed when they began | late by, "
        "mean and most [steps] | at "
        "another triangle | not "
        "there |\n|---|---|---|---|---|---|---|---|\n";
    for (std::size_t s = 0; s < piles.size(); ++s) {
        const std::string& name = piles[s].name;
        std::vector<Mode> modes;
        modes.push_back(mode("off", Temporal::off, false));
        modes.push_back(mode("paper", Temporal::paper, false));
        modes.push_back(mode("paper, predicting", Temporal::paper, true));
        modes.push_back(mode(fmt::format("paper, predicting, full pass every {}", seldom),
                             Temporal::paper, true));
        modes.back().settings.full_every = seldom;
        modes.push_back(mode("certified", Temporal::certified, false));
        measure(piles[s].loop.recording, modes, "tables 2 and 3, " + name);
        for (const bool second : {false, true}) {
            std::vector<double> ms, contacts;
            for (const Mode& m : modes) {
                ms.push_back(m.half(second).median_ms());
                contacts.push_back(static_cast<double>(m.half(second).contacts));
            }
            page.line(
                "| {}, {} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.2f} | {:+.1f} % | "
                "{:+.1f} % | {:+.1f} % | "
                "{:.2f} |",
                name, second ? "second" : "first", ms[0], ms[1], ms[2], ms[3], ms[4], ms[0] / ms[1],
                100 * (ms[2] / ms[1] - 1), 100 * (contacts[2] / std::max(contacts[1], 1.0) - 1),
                100 * (ms[3] / ms[1] - 1), ms[0] / ms[4]);
            table.rows.push_back(
                {static_cast<double>(s), second ? 2.0 : 1.0, ms[0], ms[1], ms[2], ms[3], ms[4]});
        }
        for (std::size_t m = 1; m < modes.size(); ++m) {
            const ContactError& e = modes[m].comparison.error();
            errors += fmt::format(
                "| {} | {} | {} of {} | {:.3f} % | {} of {} | {:.1f}, {} | {} | {} |\n", name,
                modes[m].name, e.missed, e.expected, 100 * e.missed_share(), e.first_missed,
                e.first,
                e.first_missed > 0
                    ? static_cast<double>(e.late_steps) / static_cast<double>(e.first_missed)
                    : 0.0,
                e.latest, e.wrong, e.added);
        }
    }
    page.line("\nThe paper, in milliseconds: ");
    for (const Figures& f : paper)
        page.line("{} {} full, {} iterative, {} with prediction;", f.scene, f.full, f.iterative,
                  f.predictive);
    page.line("\nWhat these times cost in contacts, against *off*, over the whole motion:");
    page.line("{}", errors);
    page.csv(table, "tables_2_3");
}

}  // namespace pierce::app
