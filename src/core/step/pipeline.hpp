#pragma once

#include <algorithm>
#include <bit>
#include <utility>

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/execute/stage_timer.hpp"
#include "core/execute/stage_traits.hpp"
#include "core/step/common/bounds.hpp"
#include "core/step/common/contact_keys.hpp"
#include "core/step/common/count.hpp"
#include "core/step/common/frame_fit.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/common/records.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/edges/edge_chords.hpp"
#include "core/step/margin/margin.hpp"
#include "core/step/self_overlap/self_overlap.hpp"
#include "core/step/separation/separation.hpp"
#include "core/step/sheets/sheets.hpp"
#include "core/step/solids/certificate_of.hpp"
#include "core/step/solids/classify.hpp"
#include "core/step/solids/contacts.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/displacement.hpp"
#include "core/step/solids/ray_gen.hpp"
#include "core/step/solids/remember.hpp"
#include "core/step/solids/reprojection.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "core/step/solids/walk.hpp"
#include "core/step/step_lists.hpp"
#include "pierce/explain.hpp"
#include "pierce/step_stats.hpp"

namespace pierce {

/// The step on any executor and tracer. It is in one file, although that is long, so that it can be
/// read from top to bottom. It owns the buffers between stages; buffers grow and are kept, so a
/// steady step allocates none of them.
template <Executor E, Tracer<E> T>
class Pipeline {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Pipeline(E& executor, T& tracer)
        : executor_(executor),
          tracer_(tracer),
          tools_(executor, tracer),
          edges_(tools_),
          self_overlap_(tools_),
          reprojection_(tools_),
          separation_(tools_, reprojection_),
          margin_(tools_),
          sheets_(tools_) {}

    ~Pipeline() {
        now_.leave_contacts();
        last_.leave_contacts();
    }
    Pipeline(const Pipeline&) = delete;
    Pipeline& operator=(const Pipeline&) = delete;

    /// Runs one step, up to its contacts. `stats` gets the stages' times here, and everything else
    /// from report() once the executor is done.
    void step(const Scene& scene, StepStats& stats) {
        StageTimer stage(executor_, *scene.plan, stats);  // leaves out what the plan does not need
        const Plan& plan = *scene.plan;
        recall(plan);
        forget();

        // Sheets place all bodies while pairs are looked for. They do not if there are solids, too:
        // most solids have no sheet near.
        if (E::traits.overlaps_updates && !plan.casts_rays)
            stage(StageId::sheets, [&] {
                executor_.await_ghosts();
                sheets_.bound_all(scene);
            });
        stage(StageId::bounds, [&] { bounds(scene); });
        stage(StageId::update, [&] { tools_.update_all(scene.bodies); });
        stage(StageId::pairs, [&] { pairs(scene); });
        stage(StageId::sheets, [&] { sheets_.find(scene, pairs_.pairs, view_of(pairs_.links)); });
        stage(StageId::displacement, [&] { displacement(scene); });
        stage(StageId::vertex_cull, [&] { vertex_cull(scene); });
        stage(StageId::ray_gen, [&] { ray_gen(scene); });
        stage(StageId::edges, [&] { edges(scene); });
        stage(StageId::walk, [&] { walk(scene); });
        stage(StageId::update, [&] { tools_.update(scene.bodies, full_rays(plan)); });
        stage(StageId::trace, [&] { trace(scene); });
        stage(StageId::classify, [&] { test_inside(scene); });
        if (plan.traces_own_exits) own_exits(plan, scene.bodies, stage);
        stage(StageId::classify, [&] { test_own_exits(scene); });
        stage(StageId::self_overlap,
              [&] { self_overlap_.test(scene, view_of(pairs_.pairs), batch_); });
        stage(plan.reprojects ? StageId::reproject : StageId::separation,
              [&] { reproject(scene); });
        stage(StageId::separation, [&] { separation(scene); });
        stage(StageId::margin, [&] { margin(scene); });
        // Later stages change neither hits nor own rays.
        stage(StageId::statistics, [&] { executor_.beside([&] { count_rays(); }); });
        stage(StageId::contacts, [&] { contacts(scene); });
        stage(StageId::remember, [&] { remember(scene); });
        stage(StageId::statistics, [&] { count(plan); });
        executor_.join();
    }

private:
    template <class Value>
    using Sum = typename E::template Sum<Value>;
    using Count = typename E::Count;

    /// True if candidates are tested (R2, R3) before contacts are listed: later stages read or
    /// change which of them are contacts, or the list also takes contacts over from the last step.
    static bool tests_first(const Plan& plan) {
        return plan.needs(StageId::self_overlap) || plan.needs(StageId::separation) ||
               plan.needs(StageId::reproject) || plan.needs(StageId::margin) ||
               plan.settings.keeps_contacts();
    }

    /// The rays that are traced: all rays, or those that neither a proof nor a walk replaces.
    const Buffer<Ray>& full_rays(const Plan& plan) const {
        return plan.remembers() ? routes_.full_rays : batch_.rays;
    }

    /// Clears what an earlier step has left in the lists of stages that may not run in this step.
    /// An empty list tells the other stages that its stage did not run.
    void forget() {
        now_.forget_rays();
        routes_.routes.clear();
        routes_.uncertain.clear();
        batch_.clear();
        reprojection_.clear();
        exits_.clear();
        edges_.forget();
        margin_.forget();
        sheets_.forget();
        traced_ = 0u;
    }

    // bounds: Where bodies are. Reads the vertices of deforming bodies only.
    void bounds(const Scene& scene) {
        if (scene.ranges.size < scene.bodies.size)
            executor_.for_each(scene.bodies.size,
                               stages::PlaceBox{scene.bodies, scene.plan->sheets});
        if (scene.plan->measures_deformation) measure_deformation(scene);
        if (scene.plan->needs_boxes()) edges_.measure_boxes_early(scene);
        now_.bodies.clear();
        if (!scene.plan->remembers()) return;
        now_.bodies.resize(scene.bodies.size);
        executor_.for_each(scene.bodies.size,
                           stages::CompareWithLast{.bodies = scene.bodies,
                                                   .ids = scene.ids,
                                                   .last = view_of(std::as_const(last_.bodies)),
                                                   .seen = view_of(now_.bodies)});
        if (scene.plan->settings.temporal == Temporal::paper && scene.plan->settings.predict)
            executor_.for_each(scene.bodies.size,
                               stages::MeasurePredictionRange{scene.bodies, scene.plan->settings});
    }

    void measure_deformation(const Scene& scene) {
        const Count blocks = executor_.in_sixteens(scene.block_items.size),
                    bodies = executor_.in_sixteens(scene.ranges.size);
        bounds_.blocks.resize(scene.block_items.size);
        if (scene.plan->casts_rays) {
            bounds_.moments.resize(scene.block_items.size);
            const auto measure = [&](std::uint32_t first, std::uint32_t count) {
                executor_.for_each(
                    executor_.in_sixteens(count),
                    stages::MeasurePatches{.bodies = scene.bodies,
                                           .items = {scene.block_items.data + first, count},
                                           .blocks = scene.blocks,
                                           .patches = scene.patches,
                                           .moments = {bounds_.moments.data() + first, count}});
            };
            measure(0, scene.own_blocks());
            executor_.await_ghosts();
            measure(scene.own_blocks(), scene.ghost_blocks);
            executor_.for_each(
                bodies, stages::FitFrame{scene.bodies, scene.ranges, view_of(bounds_.moments)});
            executor_.for_each(blocks, stages::MeasureBounds{.bodies = scene.bodies,
                                                             .items = scene.block_items,
                                                             .seen = scene.seen,
                                                             .bounds = view_of(bounds_.blocks)});
        } else {
            executor_.await_ghosts();
            executor_.for_each(blocks, stages::MeasureBoxes{scene.bodies, scene.block_items,
                                                            view_of(bounds_.blocks)});
        }
        executor_.for_each(bodies, stages::JoinBounds{.bodies = scene.bodies,
                                                      .ranges = scene.ranges,
                                                      .bounds = view_of(bounds_.blocks),
                                                      .has_fit = scene.plan->casts_rays});
    }

    // pairs: Bodies whose boxes overlap, sorted by (a, b), and which of the last step's pairs each
    // pair was.
    void pairs(const Scene& scene) {
        const std::uint32_t bodies = scene.bodies.size;
        now_.by_world = scene.world_begins.size > 0;
        const bool are_comparable = now_.by_world == last_.by_world;
        const stages::LinkPair link{.bodies = scene.bodies,
                                    .ids = scene.ids,
                                    .as_keys = {now_.by_world},
                                    .last_keys = are_comparable
                                                     ? view_of(std::as_const(last_.pair_keys))
                                                     : View<const std::uint64_t>{},
                                    .last = view_of(last_.identities)};
        const stages::WantedPairs wanted{.bodies = scene.bodies,
                                         .ids = scene.ids,
                                         .excluded = scene.excluded,
                                         .filter = scene.pair_filter,
                                         .part = scene.part};
        if (bodies <= E::traits.bodies_at_once && !link.as_keys.by_world)
            return executor_.emit(ListId::pairs, Count{bodies * bodies},
                                  stages::FindPairs{link, wanted}, now_.pair_keys, pairs_.pairs,
                                  now_.identities, pairs_.links);
        sweep(scene, wanted, link.as_keys);
        const Count total = count_of(now_.pair_keys);
        pairs_.pairs.resize(total);
        now_.identities.resize(total);
        pairs_.links.resize(total);
        executor_.for_each(total, stages::LinkSorted{.link = link,
                                                     .keys = view_of(now_.pair_keys),
                                                     .pairs = view_of(pairs_.pairs),
                                                     .identities = view_of(now_.identities),
                                                     .links = view_of(pairs_.links)});
    }

    void sweep(const Scene& scene, const stages::WantedPairs& wanted, stages::PairKeys as_keys) {
        const View<const BodyView> bodies = scene.bodies;
        const auto worlds = static_cast<int>(std::bit_width(scene.world_begins.size));
        sort_.keys.resize(bodies.size);
        sort_.values.resize(bodies.size);
        pairs_.sweep.resize(bodies.size);
        executor_.for_each(bodies.size,
                           stages::SweepKey{bodies, view_of(sort_.keys), view_of(sort_.values)});
        tools_.sort(stages::sweep_key_bits + worlds, sort_.keys, sort_.values, pairs_.body_keys,
                    sort_.order);
        executor_.for_each(
            bodies.size, stages::GatherSweep{bodies, view_of(sort_.order), view_of(pairs_.sweep)});
        const std::uint32_t walks = E::traits.sweep_walks;
        executor_.emit(ListId::box_pairs, Count{bodies.size * walks},
                       stages::SweepPairs{.items = view_of(pairs_.sweep),
                                          .bodies = bodies,
                                          .world_begins = scene.world_begins,
                                          .keys = as_keys,
                                          .walks = walks},
                       pairs_.box_keys);
        executor_.emit(ListId::swept_pairs, count_of(pairs_.box_keys),
                       stages::TestPair{wanted, as_keys, view_of(pairs_.box_keys)}, sort_.keys);
        sort_.values.resize(count_of(sort_.keys));
        tools_.sort(as_keys.by_world ? 64 : 32 + std::bit_width(bodies.size), sort_.keys,
                    sort_.values, now_.pair_keys, sort_.order);
    }

    // displacement: How far pairs have moved.
    void displacement(const Scene& scene) {
        const Count directed_count = 2 * count_of(pairs_.pairs);
        now_.directed.resize(directed_count);
        executor_.for_each(directed_count,
                           stages::MeasureDisplacement{.bodies = scene.bodies,
                                                       .pairs = view_of(pairs_.pairs),
                                                       .links = view_of(pairs_.links),
                                                       .last = view_of(last_.directed),
                                                       .settings = scene.plan->settings,
                                                       .memory = view_of(now_.directed)});
    }

    // vertex_cull: Patches, then vertices, that may be inside the other body.
    void vertex_cull(const Scene& scene) {
        const View<const BodyView> bodies = scene.bodies;
        const Temporal temporal = scene.plan->settings.temporal;
        const Count directed_count = 2 * count_of(pairs_.pairs);
        cull_.directed.resize(directed_count);
        cull_.block_offsets.resize(directed_count);
        const bool asks = scene.plan->misses_no_overlap() || scene.plan->reprojects;
        pairs_.marks.resize(asks ? count_of(pairs_.pairs) : Count{0u});
        pairs_.deep.resize(asks ? 2 * count_of(pairs_.pairs) : Count{0u});
        pairs_.depth.resize(asks && scene.plan->margins ? count_of(pairs_.pairs) : Count{0u});
        executor_.emit(ListId::pair_blocks, directed_count,
                       stages::DirectPair{.bodies = bodies,
                                          .pairs = view_of(pairs_.pairs),
                                          .links = view_of(pairs_.links),
                                          .memory = view_of(now_.directed),
                                          .last = view_of(last_.directed),
                                          .settings = scene.plan->settings,
                                          .directed = view_of(cull_.directed),
                                          .begins = view_of(cull_.block_offsets),
                                          .marks = marks()},
                       cull_.blocks);
        const bool records = scene.plan->remembers();
        if (records) now_.blocks.resize(count_of(cull_.blocks));
        tools_.share_out(count_of(cull_.blocks), [&](auto share, Count blocks) {
            executor_.emit(ListId::near_patches, blocks,
                           stages::CullBlock<decltype(share)>{.bodies = bodies,
                                                              .directed = view_of(cull_.directed),
                                                              .blocks = view_of(cull_.blocks),
                                                              .temporal = temporal,
                                                              .seen = scene.seen,
                                                              .last = last_.of_vertices(),
                                                              .records = view_of(now_.blocks)},
                           cull_.patches);
        });
        if (records) now_.patches.resize(count_of(cull_.patches));
        tools_.share_out(count_of(cull_.patches), [&](auto share, Count patches) {
            const stages::CullVertices<decltype(share)> vertices{
                .bodies = bodies,
                .directed = view_of(cull_.directed),
                .patches = view_of(cull_.patches),
                .temporal = temporal,
                .seen = scene.seen,
                .last = last_.of_vertices(),
                .block_offsets = view_of(cull_.block_offsets),
                .block_records = view_of(now_.blocks),
                .records = view_of(now_.patches)};
            if (records)
                executor_.emit(ListId::near_vertices, patches, vertices, batch_.sources,
                               routes_.routes, now_.vertices);
            else
                executor_.emit(ListId::near_vertices, patches, vertices, batch_.sources);
        });
    }

    // ray_gen: A ray per vertex left, or what replaces the ray.
    void ray_gen(const Scene& scene) {
        const Count count = count_of(batch_.sources);
        batch_.rays.resize(count);
        batch_.hits.resize(count);
        batch_.meetings.resize(count);
        executor_.for_each(count, stages::GenerateRay{.bodies = scene.bodies,
                                                      .directed = view_of(cull_.directed),
                                                      .sources = view_of(batch_.sources),
                                                      .settings = scene.plan->settings,
                                                      .records = view_of(now_.vertices),
                                                      .rays = view_of(batch_.rays),
                                                      .hits = view_of(batch_.hits),
                                                      .meetings = view_of(batch_.meetings),
                                                      .routes = view_of(routes_.routes)});
    }

    // walk: Runs the walks; lost walks join the full rays.
    void walk(const Scene& scene) {
        const Count walks = tools_.list(ListId::walks, count_of(batch_.rays),
                                        stages::HasRoute{view_of(routes_.routes), Route::walk},
                                        routes_.walks);
        routes_.counts.resize(walks);
        routes_.found.resize(count_of(batch_.rays));
        executor_.for_each(walks, stages::Walk{.bodies = scene.bodies,
                                               .directed = view_of(cull_.directed),
                                               .rays = view_of(batch_.rays),
                                               .sources = view_of(batch_.sources),
                                               .slots = view_of(routes_.walks),
                                               .temporal = scene.plan->settings.temporal,
                                               .hits = view_of(batch_.hits),
                                               .routes = view_of(routes_.routes),
                                               .records = view_of(now_.vertices),
                                               .found = view_of(routes_.found),
                                               .meetings = view_of(batch_.meetings),
                                               .counts = view_of(routes_.counts)});
        const Count full = tools_.list(ListId::full_rays, count_of(batch_.rays),
                                       stages::HasRoute{view_of(routes_.routes), Route::full},
                                       routes_.full);
        routes_.full_rays.resize(full);
        executor_.for_each(full, stages::Gather<Ray>{view_of(batch_.rays), view_of(routes_.full),
                                                     view_of(routes_.full_rays)});
    }

    stages::PairMarks marks() {
        return {.words = view_of(pairs_.marks),
                .deep = view_of(pairs_.deep),
                .depth = view_of(pairs_.depth)};
    }

    StepOfPairs<E> step_of_pairs(const Scene& scene) {
        return {.scene = scene,
                .count = count_of(pairs_.pairs),
                .pairs = view_of(pairs_.pairs),
                .directed = view_of(cull_.directed),
                .memory = view_of(now_.directed),
                .links = view_of(pairs_.links),
                .marks = marks()};
    }

    // edges: Which parts of edges are inside the other body, and a ray for each.
    void edges(const Scene& scene) {
        const stages::GenerateChordRays rays = edges_.find(step_of_pairs(scene), 0, batch_,
                                                           routes_.routes);
        executor_.for_each(edges_.chord_count(), rays);
    }

    // trace: The triangle each ray crosses first.
    void trace(const Scene& scene) {
        const bool remembers = scene.plan->remembers();
        traced_ = count_of(full_rays(*scene.plan));
        tools_.trace(scene.bodies, full_rays(*scene.plan),
                     remembers ? routes_.full_hits : batch_.hits);
        if (remembers) scatter_hits();
        if (scene.plan->velocity_rays) relate_to_layers(scene.bodies);
    }

    void scatter_hits() {
        executor_.for_each(count_of(routes_.full),
                           stages::Scatter<Hit>{view_of(routes_.full_hits), view_of(routes_.full),
                                                view_of(batch_.hits)});
    }

    void relate_to_layers(View<const BodyView> bodies) {
        executor_.for_each(count_of(batch_.rays),
                           stages::RelateToLayer{.bodies = bodies,
                                                 .directed = view_of(cull_.directed),
                                                 .sources = view_of(batch_.sources),
                                                 .rays = view_of(batch_.rays),
                                                 .hits = view_of(batch_.hits)});
    }

    // classify, first part: R1: which rays start inside their target.
    void test_inside(const Scene& scene) {
        const Count count = count_of(batch_.rays);
        const stages::TestInside inside{.bodies = scene.bodies,
                                        .rays = view_of(batch_.rays),
                                        .hits = view_of(batch_.hits),
                                        .routes = view_of(routes_.routes),
                                        .meetings = view_of(batch_.meetings)};
        if (scene.plan->traces_own_exits)
            executor_.emit(ListId::candidates, count,
                           stages::GenerateOwnRays{.inside_target = inside,
                                                   .pairs = view_of(pairs_.pairs),
                                                   .chords = edges_.chords(),
                                                   .sources = view_of(batch_.sources)},
                           batch_.candidates, exits_.rays, exits_.starts_inside);
        else
            executor_.emit(ListId::candidates, count, inside, batch_.candidates);
    }

    /// Second rays, of candidates whose own exit is not known.
    void own_exits(const Plan& plan, View<const BodyView> bodies, StageTimer<E>& stage) {
        stage(StageId::update, [&] { tools_.update(bodies, exits_.rays); });
        stage(StageId::trace, [&] {
            batch_.keep.resize(count_of(batch_.candidates));
            exits_.hits.resize(count_of(exits_.rays));
            if (tests_first(plan))
                tools_.trace_between(bodies, exits_.rays, exits_.hits, NoStage{},
                                     own_exit_test(bodies));
            else
                tools_.trace(bodies, exits_.rays, exits_.hits);
        });
    }

    // classify, second part: R2 and R3: which candidates are contacts. If no stage needs the answer
    // earlier, candidates are tested as contacts are listed.
    void test_own_exits(const Scene& scene) {
        if (scene.plan->traces_own_exits && tests_first(*scene.plan)) return;  // own_exits() did
        batch_.keep.resize(count_of(batch_.candidates));
        if (tests_first(*scene.plan))
            executor_.for_each(count_of(batch_.candidates), own_exit_test(scene.bodies));
    }
    stages::TestOwnExit own_exit_test(View<const BodyView> bodies) {
        return {.bodies = bodies,
                .rays = view_of(batch_.rays),
                .meetings = view_of(batch_.meetings),
                .candidates = view_of(batch_.candidates),
                .own_rays = view_of(exits_.rays),
                .own_hits = view_of(exits_.hits),
                .starts_inside = view_of(exits_.starts_inside),
                .keep = view_of(batch_.keep)};
    }

    // reproject: Contacts move to the closest point of the target's surface, if the plan asks for
    // it. Which pairs have a contact, and which have depth, is known from then on.
    void reproject(const Scene& scene) {
        reprojection_.decide(step_of_pairs(scene), batch_, 0u, count_of(batch_.candidates),
                             edges_.chords(), edges_.flat(),
                             view_of(std::as_const(routes_.routes)));
    }

    // separation: Pairs that overlap without a contact so far.
    void separation(const Scene& scene) {
        separation_.separate(step_of_pairs(scene), edges_, batch_, routes_.routes);
    }

    // margin: What does not overlap and is nearer than the margin.
    void margin(const Scene& scene) {
        margin_.find(step_of_pairs(scene), edges_, batch_, routes_.routes);
    }

    /// Sorts the contacts' keys. With margins it leaves out vertices that are near and in contact
    /// by a ray, too.
    void sort_contacts(const Scene& scene) {
        const int bits = ContactKey::pair_shift +
                         std::bit_width(static_cast<std::uint32_t>(pairs_.pairs.size()));
        if (!scene.plan->margins)
            return tools_.sort(bits, sort_.keys, sort_.values, now_.contact_keys, sort_.order);
        tools_.sort(bits, sort_.keys, sort_.values, with_duplicates_.keys, with_duplicates_.order);
        executor_.emit(
            ListId::first_contacts, count_of(with_duplicates_.keys),
            stages::DropDuplicates{.sources = view_of(batch_.sources),
                                   .candidates = view_of(batch_.candidates),
                                   .bodies = scene.bodies,
                                   .pairs = view_of(pairs_.pairs),
                                   .chords = edges_.chords(),
                                   .meetings = view_of(batch_.meetings),
                                   .order = view_of(std::as_const(with_duplicates_.order)),
                                   .keys = view_of(std::as_const(with_duplicates_.keys))},
            now_.contact_keys, sort_.order);
    }

    // contacts: The list, in (pair, side, vertex) order. Candidates are tested on the way, unless
    // they were tested before.
    void contacts(const Scene& scene) {
        const Count candidates = count_of(batch_.candidates);
        const bool keeps = scene.plan->settings.keeps_contacts();
        const stages::KeyContacts keys{.chords = edges_.chords(),
                                       .sources = view_of(batch_.sources),
                                       .candidates = view_of(batch_.candidates),
                                       .keep = view_of(batch_.keep),
                                       .directed = view_of(cull_.directed),
                                       .links = view_of(pairs_.links),
                                       .last_keys = view_of(last_.contact_keys)};
        if (keeps)
            executor_.emit(
                ListId::contacts,
                Count{executor_.number(candidates) + executor_.number(count_of(pairs_.pairs))},
                keys, sort_.keys, sort_.values);
        else if (tests_first(*scene.plan))
            executor_.emit(ListId::contacts, candidates, keys, sort_.keys, sort_.values);
        else
            executor_.emit(ListId::contacts, candidates,
                           FindAfter(own_exit_test(scene.bodies), keys), sort_.keys, sort_.values);
        sort_contacts(scene);
        const Count total = count_of(now_.contact_keys);
        if (scene.plan->misses_no_overlap() || scene.plan->margins)
            executor_.for_each(total, stages::OrderChords{.chords = edges_.chords(),
                                                          .sources = view_of(batch_.sources),
                                                          .candidates = view_of(batch_.candidates),
                                                          .keys = view_of(now_.contact_keys),
                                                          .order = view_of(sort_.order)});
        now_.ages.resize(total);
        now_.contacts.resize(total);
        executor_.reduce(
            total,
            stages::FillContact{.bodies = scene.bodies,
                                .ids = scene.ids,
                                .pairs = view_of(pairs_.pairs),
                                .chords = edges_.chords(),
                                .sources = view_of(batch_.sources),
                                .found_rays = batch_.results(),
                                .aimed = reprojection_.moved(),
                                .accepted = reprojection_.accepted(),
                                .decided = reprojection_.decided(),
                                .marks = marks(),
                                .candidates = view_of(batch_.candidates),
                                .order = view_of(sort_.order),
                                .keys = view_of(now_.contact_keys),
                                .routes = view_of(routes_.routes),
                                .found = view_of(routes_.found),
                                .links = view_of(pairs_.links),
                                .last_keys = view_of(last_.contact_keys),
                                .last_ages = view_of(last_.ages),
                                .last_contacts = view_of(std::as_const(last_.contacts)),
                                .records = view_of(now_.vertices),
                                .looks = scene.plan->settings.looks(),
                                .ages = view_of(now_.ages),
                                .contacts = view_of(now_.contacts)},
            sums_.contacts);
    }

    // remember: What the next step needs to know.
    void remember(const Scene& scene) {
        const Count full = count_of(routes_.full);
        executor_.for_each(full, stages::Remember{.bodies = scene.bodies,
                                                  .directed = view_of(cull_.directed),
                                                  .rays = view_of(batch_.rays),
                                                  .sources = view_of(batch_.sources),
                                                  .temporal = scene.plan->settings.temporal,
                                                  .hits = view_of(batch_.hits),
                                                  .meetings = view_of(batch_.meetings),
                                                  .slots = view_of(routes_.full),
                                                  .records = view_of(now_.vertices)});
        if (scene.plan->settings.temporal != Temporal::certified) return;

        const Count uncertain = tools_.list(ListId::uncertain_rays, full,
                                            stages::IsUncertain{.bodies = scene.bodies,
                                                                .directed = view_of(cull_.directed),
                                                                .rays = view_of(batch_.rays),
                                                                .sources = view_of(batch_.sources),
                                                                .hits = view_of(batch_.hits),
                                                                .slots = view_of(routes_.full),
                                                                .records = view_of(now_.vertices)},
                                            routes_.uncertain);
        routes_.full_rays.resize(uncertain);
        executor_.for_each(uncertain, stages::ProlongRay{.bodies = scene.bodies,
                                                         .rays = view_of(batch_.rays),
                                                         .slots = view_of(routes_.full),
                                                         .uncertain = view_of(routes_.uncertain),
                                                         .prolonged = view_of(routes_.full_rays)});
        tools_.update(scene.bodies, routes_.full_rays);
        if (scene.plan->settings.inside_is_contact())
            routes_.full_hits.clear();
        else
            tools_.trace(scene.bodies, routes_.full_rays, routes_.full_hits);
        executor_.for_each(uncertain,
                           stages::LimitToCertificate{scene.bodies, view_of(routes_.full_hits),
                                                      view_of(routes_.full_rays)});
        const View<const std::uint32_t> closest = tools_.closest(scene.bodies, routes_.full_rays);
        executor_.reduce(uncertain,
                         stages::Certify{.bodies = scene.bodies,
                                         .directed = view_of(cull_.directed),
                                         .sources = view_of(batch_.sources),
                                         .slots = view_of(routes_.full),
                                         .uncertain = view_of(routes_.uncertain),
                                         .limited = view_of(routes_.full_rays),
                                         .closest = closest,
                                         .records = view_of(now_.vertices)},
                         sums_.proofs);
    }

    // statistics: What the step did.
    void count(const Plan& plan) {
        if (plan.sheets)
            sheets_.add_up(view_of(std::as_const(now_.contact_keys)), sums_.sheet_contacts);
        if (!plan.remembers()) return;
        executor_.reduce(count_of(routes_.counts), stages::CountWalk{view_of(routes_.counts)},
                         sums_.walks);
        executor_.reduce(count_of(routes_.routes), stages::CountSkipped{view_of(routes_.routes)},
                         sums_.skipped);
        if (plan.settings.temporal == Temporal::certified)
            executor_.reduce(count_of(routes_.routes), stages::CountLooked{view_of(routes_.routes)},
                             sums_.looked);
        executor_.reduce(count_of(now_.vertices), stages::CountPredicted{view_of(now_.vertices)},
                         sums_.predicted);
        executor_.reduce(count_of(pairs_.pairs), stages::CountFullPass{view_of(now_.directed)},
                         sums_.full_passes);
    }

    void count_rays() {
        executor_.reduce(count_of(batch_.hits), stages::CountHit{view_of(batch_.hits)}, sums_.hits);
        executor_.reduce(count_of(exits_.rays), stages::CountTraced{view_of(exits_.rays)},
                         sums_.own_rays);
        tracer_.add_up(executor_);
    }

public:
    /// Steps without sheets in which nothing has changed, after one in which nothing had either:
    /// they would find the same contacts, each one step older.
    void step_at_rest(std::uint32_t steps) {
        const bool are_kept = now_.kept.use_count() > 1;
        Buffer<Contact> same;
        if (are_kept) same = now_.contacts;
        now_.leave_contacts();
        if (are_kept) now_.contacts = std::move(same);
        executor_.for_each(count_of(now_.contacts),
                           stages::GrowOlder{view_of(now_.contacts), view_of(now_.ages), steps});
    }

    /// What the last step did and found.
    void report(const Plan& plan, StepStats& stats) {
        stats.pairs = executor_.number(count_of(pairs_.pairs));
        stats.rays = executor_.number(traced_);
        stats.contacts = executor_.number(count_of(now_.contacts));
        stats.hits = executor_.read(sums_.hits);
        stats.own_rays = executor_.read(sums_.own_rays);
        if (plan.misses_no_overlap()) {
            stats.edges = executor_.number(edges_.near_edges());
            stats.chords = executor_.number(edges_.chord_count()) -
                           executor_.number(margin_.edge_pairs());
            stats.rays += separation_.late_rays();
            stats.inside_tests = separation_.inside_tests();
            stats.separated_pairs = separation_.deep_pairs();
        }
        const TracerCounts after = tracer_.counts(executor_);
        stats.refits = static_cast<std::uint32_t>(after.refits - reported_.refits);
        stats.rebuilds = static_cast<std::uint32_t>(after.rebuilds - reported_.rebuilds);
        stats.triangle_tests = after.triangle_tests - reported_.triangle_tests;
        reported_ = after;
        stages::ContactSums contacts = plan.casts_rays ? executor_.read(sums_.contacts)
                                                       : stages::ContactSums{};
        if (plan.sheets) {
            contacts = contacts + executor_.read(sums_.sheet_contacts);
            stats.contacts += executor_.number(count_of(sheets_.contacts()));
            stats.triangle_pairs = sheets_.triangle_pairs();
            stats.feature_pairs = sheets_.feature_pairs();
            stats.crossings = contacts.crossings;
            stats.remembered = contacts.remembered;
            stats.tangled = contacts.tangled;
        }
        stats.self_contacts = contacts.self;
        stats.touching_pairs = contacts.touching_pairs;
        stats.edge_contacts = contacts.edges;
        stats.reprojected = contacts.reprojected;
        stats.predictions_true = contacts.predictions_true;
        stats.penetration_max = contacts.depth_max;
        if (stats.contacts > 0) stats.penetration_mean = contacts.depth / stats.contacts;
        if (!plan.remembers()) return;
        const stages::WalkSums walks = executor_.read(sums_.walks);
        stats.walks = executor_.number(count_of(routes_.walks));
        stats.walk_steps = walks.steps;
        stats.lost_walks = walks.lost;
        if (plan.settings.temporal == Temporal::certified) {
            stats.certified = executor_.read(sums_.skipped);
            stats.looks = executor_.read(sums_.looked);
            stats.proofs = executor_.read(sums_.proofs);
        }
        stats.predictions = executor_.read(sums_.predicted);
        stats.full_passes = executor_.read(sums_.full_passes);
    }

    /// Makes this step's records those of the last step.
    void recall(const Plan& plan) {
        std::swap(now_, last_);
        // Contacts stay in `now_`, unless the next step may take some over.
        if (!plan.settings.keeps_contacts()) {
            std::swap(now_.contacts, last_.contacts);
            std::swap(now_.kept, last_.kept);
        }
        now_.leave_contacts();
        edges_.recall();
        sheets_.recall();
    }

    /// What the last step has left for the next one.
    StepMemory memory() const {
        StepMemory m;
        now_.save(executor_, m);
        sheets_.save(m);
        return m;
    }

    /// Makes `m` the last step's memory.
    void restore(const StepMemory& m) {
        now_.leave_contacts();
        now_.restore(executor_, m);
        edges_.forget();
        sheets_.restore(m);
    }

    const Buffer<Contact>& contacts() const { return now_.contacts; }
    std::shared_ptr<const Contact> keep_contacts() { return now_.keep_contacts(); }
    /// The contacts of sheets.
    const Buffer<Contact>& sheet_contacts() const { return sheets_.contacts(); }
    const Buffer<Pair>& pairs() const { return pairs_.pairs; }

    /// The proof that spared a vertex of a pair its ray in the last step, if there was one.
    Certificate certificate(View<const BodyView> bodies, Pair pair, std::uint32_t side,
                            std::uint32_t vertex) const {
        const auto at = std::find(pairs_.pairs.begin(), pairs_.pairs.end(), pair);
        if (at == pairs_.pairs.end() || now_.directed.empty() || now_.blocks.empty()) return {};
        const auto direction = 2 * static_cast<std::size_t>(at - pairs_.pairs.begin()) + side;
        return certificate_of(bodies, pair, side, vertex, now_.directed[direction],
                              now_.of_vertices());
    }

private:
    E& executor_;
    T& tracer_;
    StepTools<E, T> tools_;
    EdgeChords<E, T> edges_;
    SelfOverlap<E, T> self_overlap_;
    Reprojection<E, T> reprojection_;
    Separation<E, T> separation_;
    Margin<E, T> margin_;
    Sheets<E, T> sheets_;

    StepRecords<E> now_, last_;
    BoundsLists<E> bounds_;
    PairLists<E> pairs_;
    CullLists<E> cull_;
    RayBatch<E> batch_;
    RouteLists<E> routes_;
    ExitLists<E> exits_;
    SortScratch<E> sort_;
    SortScratch<E> with_duplicates_;
    StepSums<E> sums_;
    Count traced_ = 0u;  ///< rays of vertices, of chords, and along velocities
    TracerCounts reported_;
};

}  // namespace pierce
