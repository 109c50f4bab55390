#include <algorithm>

#include "paper_modes.hpp"
#include "paper_sections.hpp"

namespace pierce::app {

using scenes::ContactError;

void tables_2_and_3(std::span<const NamedRecording> recordings, Page& page) {
    struct Figures {
        const char* scene;
        const char* full;
        const char* iterative;
        const char* predictive;
    };
    constexpr Figures paper[] = {{"tori", "56.7", "36.2", "37.2"}, {"bunnies", "129.2", "116.3", "118.6"}};
    Table table{{"scene", "off_ms", "paper_ms", "predict_ms", "certified_ms", "paper_missed_depth", "predict_missed_depth"},
                {}};

    page.line("## Tables 2 and 3: iterative and predictive rays\n");
    page.line(
        "Narrow phase per frame: median over the second half of the motion, one thread, all modes on the same frames in "
        "turn.");
    page.line(
        "*Off* traces every vertex that is not culled; *paper* walks from the last hits; *certified* leaves out what is "
        "proved to be");
    page.line("needless and has the contacts of *off*, all of them.\n");
    page.line(
        "| scene | off [ms] | paper [ms] | + prediction [ms] | certified [ms] | off / paper | paper's 1.57, 1.11 | "
        "prediction costs | "
        "paper's 2.8 %, 2.0 % | and finds more contacts | off / certified |");
    page.line("|---|---|---|---|---|---|---|---|---|---|---|");
    std::string errors =
        "\n| scene | mode | missed contacts | of the depth | missed when they began | late by, mean and most [steps] | at "
        "another triangle | not "
        "there |\n|---|---|---|---|---|---|---|---|\n";
    for (std::size_t s = 0; s < recordings.size(); ++s) {
        const auto& [name, recording] = recordings[s];
        std::vector<Mode> modes;
        modes.push_back(mode("off", Temporal::off, false));
        modes.push_back(mode("paper", Temporal::paper, false));
        modes.push_back(mode("paper, predicting", Temporal::paper, true));
        modes.push_back(mode("certified", Temporal::certified, false));
        measure(recording, modes, "tables 2 and 3, " + name);
        const double off = modes[0].median_ms(), walking = modes[1].median_ms(), predicting = modes[2].median_ms(),
                     certified = modes[3].median_ms();
        const bool bunnies = name.find("bunnies") != std::string::npos;
        const bool soft = name.find("soft") != std::string::npos;
        page.line("| {} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.2f} | {} | {:+.1f} % | {} | {:+.1f} % | {:.2f} |", name,
                  off, walking, predicting, certified, off / walking,
                  soft      ? "-"
                  : bunnies ? "1.11"
                            : "1.57",
                  100 * (predicting / walking - 1),
                  soft      ? "-"
                  : bunnies ? "+2.0 %"
                            : "+2.8 %",
                  100 * (static_cast<double>(modes[2].contacts) / static_cast<double>(modes[1].contacts) - 1),
                  off / certified);
        for (std::size_t m = 1; m < modes.size(); ++m) {
            const ContactError& e = modes[m].comparison.error();
            errors += fmt::format(
                "| {} | {} | {} of {} | {:.3f} % | {} of {} | {:.1f}, {} | {} | {} |\n", name, modes[m].name, e.missed,
                e.expected, 100 * e.missed_share(), e.first_missed, e.first,
                e.first_missed > 0 ? static_cast<double>(e.late_steps) / static_cast<double>(e.first_missed) : 0.0, e.latest,
                e.wrong, e.added);
        }
        table.rows.push_back({static_cast<double>(s), off, walking, predicting, certified,
                              modes[1].comparison.error().missed_share(), modes[2].comparison.error().missed_share()});
    }
    page.line("\nThe paper, in milliseconds: ");
    for (const Figures& f : paper)
        page.line("{} {} full, {} iterative, {} with prediction;", f.scene, f.full, f.iterative, f.predictive);
    page.line("\nWhat these times cost in contacts, against *off*, over the whole motion:");
    page.line("{}", errors);
    page.csv(table, "tables_2_3");
}

}  // namespace pierce::app
