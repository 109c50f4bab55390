#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/output/page.hpp"
#include "app/reports/paper/paper_report.hpp"
#include "app/reports/paper/quality.hpp"
#include "scenes/recording/recording.hpp"

/// The sections of the paper's report: each measures one thing and writes it down.
namespace pierce::app {

/// A pile of falling bodies: its scene, and what rays bring about in it.
struct Pile {
    std::string name;  ///< "tori_soft"
    bool soft = false;
    scenes::SceneSetup scene;
    ClosedLoop loop;

    /// As people say it: "soft tori".
    std::string title() const { return (soft ? "soft " : "") + scene.name; }
};

/// Figures 7 and 8.
void pictures_of_piles(const Pile& tori, const Pile& bunnies, Page& page);

/// Builders of trees, rebuilt in every step and refitted.
void table_1(const PaperReportOptions& options, const Pile& soft_tori, Page& page);

/// What iterative rays save, and what prediction costs, in time and in contacts.
void tables_2_and_3(std::span<const Pile> piles, Page& page);
/// The same on a GPU, and in scenes of up to 10,000 bodies.
void tables_2_and_3_on_gpu(const PaperReportOptions& options, std::span<const Pile> piles,
                           Page& page);

/// F4: what the walk threshold costs.
void threshold_map(const Pile& pile, Page& page);

/// F12: full passes every K steps against how far predictions look.
void period_map(const Pile& pile, Page& page);

/// The loop closed, with and without prediction. Depths are those of all contacts there are, traced
/// anew in every frame.
void figure_9(const Pile& pile, const PaperReportOptions& options, Page& page);

/// Rays against Bullet's own method.
void table_4(std::span<const Quality> qualities, Page& page);

/// Figures 10 and 12: colliding pairs in each frame.
void colliding_pairs(const Quality& quality, int figure, Page& page);

/// Figures 11 and 13: average penetration depth over time.
void average_depth(const Quality& quality, int figure, Page& page);

/// Penetration against the time step.
void figure_14(const Pile& pile, const PaperReportOptions& options, Page& page);

/// The cloth's picture.
void figure_15(const PaperReportOptions& options, Page& page);

/// From which scene on a GPU is faster.
void crossover(const PaperReportOptions& options, Page& page);

}  // namespace pierce::app
