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
#include "core/step/common/count.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/common/records.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/edges/edge_chords.hpp"
#include "core/step/self_overlap/self_overlap.hpp"
#include "core/step/separation/separation.hpp"
#include "core/step/sheets/sheets.hpp"
#include "core/step/solids/classify.hpp"
#include "core/step/solids/contacts.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/displacement.hpp"
#include "core/step/solids/ray_batch.hpp"
#include "core/step/solids/ray_gen.hpp"
#include "core/step/solids/remember.hpp"
#include "core/step/solids/reproject.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "core/step/solids/walk.hpp"
#include "pierce/explain.hpp"
#include "pierce/step_stats.hpp"

namespace pierce {

/// The step, top to bottom, on any executor and tracer; in one file, long as it is, so that it can be read so. Owns the
/// buffers between stages; they grow and are kept, so a steady step allocates nothing.
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
          separation_(tools_),
          sheets_(tools_) {}

    /// One step, up to its contacts. `stats` gets the stages' times, and all else from report(), once the executor is done.
    void step(const Scene& scene, StepStats& stats) {
        StageTimer time(executor_, stats);
        recall(scene);

        // On a device all bodies are placed while their pairs are looked for; not where there are solids, too, most of which
        // have no sheet near.
        if (!E::runs_on_host && scene.plan->sheets && !scene.plan->casts_rays)
            time("sheets", [&] { sheets_.bound_all(scene); });
        time("bounds", [&] { bounds(scene); });
        if (scene.plan->casts_rays) time("update", [&] { tools_.update_all(scene.bodies); });
        time("pairs", [&] { pairs(scene); });
        if (scene.plan->sheets)
            time("sheets", [&] { sheets_.find(scene, pairs_, view_of(links_)); });
        else
            sheets_.forget();
        forget_rays();
        if (scene.plan->casts_rays)
            cast_rays(scene, time);
        else
            count_rays();
        time("stats", [&] { count(*scene.plan); });
        executor_.join();
    }

    /// What the last step did and found.
    void report(const Plan& plan, StepStats& stats) {
        const bool remembers = plan.temporal != Temporal::off;
        stats.pairs = executor_.number(count_of(pairs_));
        stats.rays = executor_.number(remembers ? count_of(full_slots_) : count_of(batch_.rays));
        stats.contacts = executor_.number(count_of(contacts_));
        stats.hits = executor_.read(hit_sum_);
        stats.own_rays = executor_.read(own_ray_sum_);
        if (plan.coverage == Coverage::complete) {
            stats.edges = executor_.number(count_of(edges_.segments()));
            stats.chords = edges_.chords().size;
            stats.inside_tests = separation_.inside_tests();
            stats.separated_pairs = separation_.deep_pairs();
        }
        const TracerCounts after = tracer_.counts(executor_);
        stats.refits = static_cast<std::uint32_t>(after.refits - reported_.refits);
        stats.rebuilds = static_cast<std::uint32_t>(after.rebuilds - reported_.rebuilds);
        stats.triangle_tests = after.triangle_tests - reported_.triangle_tests;
        reported_ = after;
        stages::ContactSums contacts = plan.casts_rays ? executor_.read(contact_sums_) : stages::ContactSums{};
        if (plan.sheets) {
            contacts = contacts + executor_.read(sheet_sums_);
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
        if (!remembers) return;
        const stages::WalkSums walks = executor_.read(walk_sums_);
        stats.walks = executor_.number(count_of(walk_slots_));
        stats.walk_steps = walks.steps;
        stats.lost_walks = walks.lost;
        if (plan.temporal == Temporal::certified) stats.certified = executor_.read(skipped_sum_);
        stats.predictions = executor_.read(predicted_sum_);
        stats.full_passes = executor_.read(full_pass_sum_);
        stats.proofs = executor_.number(count_of(uncertain_));
    }

    /// This step's memory becomes last step's.
    void recall(const Scene& scene) {
        std::swap(pair_keys_, last_pair_keys_);
        std::swap(identities_, last_identities_);
        std::swap(contact_keys_, last_contact_keys_);
        std::swap(ages_, last_ages_);
        std::swap(memory_, last_memory_);
        std::swap(block_records_, last_block_records_);
        std::swap(patch_records_, last_patch_records_);
        std::swap(records_, last_records_);
        sheets_.recall();
        std::swap(seen_bodies_, last_seen_bodies_);
        if (scene.settings.keeps_contacts()) std::swap(contacts_, last_contacts_);
        last_ = {view_of(std::as_const(last_block_records_)), view_of(std::as_const(last_patch_records_)),
                 view_of(std::as_const(last_records_))};
    }
    /// The last step never was: step() may be called again in its place.
    void forget_step(const Scene& scene) { recall(scene); }

    /// What the last step has left for the next one.
    StepMemory memory() const {
        StepMemory m;
        m.pair_keys = executor_.download(pair_keys_);
        m.identities = executor_.download(identities_);
        m.bodies = executor_.download(seen_bodies_);
        m.directed = executor_.download(memory_);
        m.blocks = executor_.download(block_records_);
        m.patches = executor_.download(patch_records_);
        m.vertices = executor_.download(records_);
        m.contact_keys = executor_.download(contact_keys_);
        m.ages = executor_.download(ages_);
        if (!m.directed.empty()) m.contacts = executor_.download(contacts_);
        sheets_.save(m);
        return m;
    }
    /// Makes it the last step's.
    void remember(const StepMemory& m) {
        const auto take = [&]<class Item>(const std::vector<Item>& from, Buffer<Item>& to) {
            executor_.upload(std::span<const Item>(from), to);
        };
        take(m.pair_keys, pair_keys_);
        take(m.identities, identities_);
        take(m.bodies, seen_bodies_);
        take(m.directed, memory_);
        take(m.blocks, block_records_);
        take(m.patches, patch_records_);
        take(m.vertices, records_);
        take(m.contact_keys, contact_keys_);
        take(m.ages, ages_);
        take(m.contacts, contacts_);
        sheets_.restore(m);
    }

    const Buffer<Contact>& contacts() const { return contacts_; }
    /// Those of sheets.
    const Buffer<Contact>& sheet_contacts() const { return sheets_.contacts(); }
    const Buffer<Pair>& pairs() const { return pairs_; }

    /// What spared a vertex of a pair its ray in the last step, if it was a proof.
    Certificate certificate(View<const BodyView> bodies, Pair pair, std::uint32_t side, std::uint32_t vertex) const {
        const auto at = std::find(pairs_.begin(), pairs_.end(), pair);
        if (at == pairs_.end() || memory_.empty() || block_records_.empty()) return {};
        const PairMemory& memory = memory_[2 * static_cast<std::size_t>(at - pairs_.begin()) + side];
        const View<const std::uint32_t> order = bodies[pair.source(side)].mesh.patch_vertices;
        if (bodies[pair.target(side)].mesh.clearance_steps.size == 0) return {};
        const auto place = static_cast<std::uint32_t>(std::find(order.begin(), order.end(), vertex) - order.begin());
        const std::uint32_t patch = place / constants::patch_size;
        const RecordsView records{view_of(block_records_), view_of(patch_records_), view_of(records_)};
        const auto until = [&](Certificate::Kind kind, float expiry) {
            const double left = static_cast<double>(expiry) - memory.odometer;
            return left > 0 ? Certificate{kind, left} : Certificate{};
        };
        const PatchRecord* in_patch = records.patch(memory.first_block, patch);
        if (in_patch == nullptr)
            return until(
                Certificate::patch,
                records.blocks[memory.first_block + patch / constants::block_size].expiry[patch % constants::block_size]);
        const VertexRecord* record = records.vertex(in_patch, place % constants::patch_size);
        return record == nullptr ? until(Certificate::patch_rest, in_patch->expiry)
                                 : until(Certificate::vertex, record->expiry);
    }

private:
    template <class Value>
    using Sum = typename E::template Sum<Value>;
    using Count = typename E::Count;

    // The stages that cast rays. A scene of nothing but sheets has none.
    void cast_rays(const Scene& scene, StageTimer<E>& time) {
        const bool remembers = scene.plan->temporal != Temporal::off;
        const bool complete = scene.plan->coverage == Coverage::complete;
        if (remembers) time("displacement", [&] { displacement(scene); });
        time("vertex_cull", [&] { vertex_cull(scene); });
        time("ray_gen", [&] { ray_gen(scene); });
        if (complete) {
            time("edges", [&] { edges_.cull(scene, view_of(directed_), view_of(blocks_)); });
            time("update", [&] { tools_.update(scene.bodies, edges_.segments()); });
            time("edges", [&] { edges_.cast(scene, view_of(directed_), batch_, routes_); });
        }
        if (remembers) time("walk", [&] { walk(scene); });
        const Buffer<Ray>& full = remembers ? full_rays_ : batch_.rays;
        time("update", [&] { tools_.update(scene.bodies, full); });
        time("trace", [&] {
            tools_.trace("trace", scene.bodies, full, remembers ? full_hits_ : batch_.hits);
            if (remembers) scatter_hits();
        });
        if (scene.plan->velocity_rays) time("sheets", [&] { relate_to_layers(scene.bodies); });
        time("classify", [&] { test_inside(scene); });
        if (scene.plan->traces_own_exits) {
            time("update", [&] { tools_.update(scene.bodies, own_rays_); });
            time("trace", [&] { tools_.trace("trace_own", scene.bodies, own_rays_, own_hits_); });
        }
        batch_.keep.resize(count_of(batch_.candidates));
        // Others want to know which candidates are contacts, or have a say in it.
        const bool others_ask = scene.plan->meets_itself || complete || scene.plan->reprojects;
        if (others_ask)
            time("classify",
                 [&] { executor_.for_each("test_own_exit", count_of(batch_.candidates), own_exit_test(scene.bodies)); });
        if (scene.plan->meets_itself) time("self", [&] { self_overlap_.test(scene, view_of(pairs_), batch_); });
        if (complete)
            time("separation",
                 [&] { separation_.separate(scene, view_of(pairs_), view_of(directed_), edges_, batch_, routes_); });
        if (scene.plan->reprojects) time("reproject", [&] { reproject(scene); });
        // What follows changes neither hits nor own rays.
        time("stats", [&] { executor_.beside([&] { count_rays(); }); });
        time("contacts", [&] { contacts(scene, others_ask); });
        if (remembers) time("remember", [&] { remember(scene); });
    }

    /// What an earlier step has left in the lists of stages that cast rays: stages may not run in this one, and others tell
    /// by an empty list that they did not.
    void forget_rays() {
        memory_.clear();
        block_records_.clear();
        patch_records_.clear();
        records_.clear();
        routes_.clear();
        batch_.clear();
        aimed_.clear();
        accepted_.clear();
        own_rays_.clear();
        own_hits_.clear();
        starts_inside_.clear();
        edges_.forget();
        contacts_.clear();
        contact_keys_.clear();
        ages_.clear();
    }

    // Stage 1. Where bodies are; only deforming ones need a look at their vertices.
    void bounds(const Scene& scene) {
        if (scene.ranges.size < scene.bodies.size)
            executor_.for_each("place_box", scene.bodies.size, stages::PlaceBox{scene.bodies, scene.plan->sheets});
        if (scene.plan->measures_deformation) measure_deformation(scene);
        seen_bodies_.clear();
        if (scene.plan->temporal == Temporal::off) return;
        seen_bodies_.resize(scene.bodies.size);
        executor_.for_each("compare_with_last", scene.bodies.size,
                           stages::CompareWithLast{scene.bodies, scene.ids, view_of(std::as_const(last_seen_bodies_)),
                                                   view_of(seen_bodies_)});
        if (scene.plan->temporal == Temporal::paper && scene.settings.predict)
            executor_.for_each("measure_reach", scene.bodies.size, stages::MeasureReach{scene.bodies, scene.settings});
    }

    void measure_deformation(const Scene& scene) {
        const Count blocks = executor_.in_sixteens(scene.block_items.size),
                    bodies = executor_.in_sixteens(scene.ranges.size);
        block_bounds_.resize(scene.block_items.size);
        if (scene.plan->casts_rays) {
            moments_.resize(scene.block_items.size);
            executor_.for_each(
                "measure_patches", blocks,
                stages::MeasurePatches{scene.bodies, scene.block_items, scene.blocks, scene.patches, view_of(moments_)});
            executor_.for_each("fit_frame", bodies, stages::FitFrame{scene.bodies, scene.ranges, view_of(moments_)});
            executor_.for_each("measure_bounds", blocks,
                               stages::MeasureBounds{scene.bodies, scene.block_items, scene.seen, view_of(block_bounds_)});
        } else {
            executor_.for_each("measure_boxes", blocks,
                               stages::MeasureBoxes{scene.bodies, scene.block_items, view_of(block_bounds_)});
        }
        executor_.for_each("join_bounds", bodies,
                           stages::JoinBounds{scene.bodies, scene.ranges, view_of(block_bounds_), scene.plan->casts_rays});
    }

    // Stage 2. Bodies whose boxes overlap, sorted by (a, b), and which of last step's pairs they were.
    void pairs(const Scene& scene) {
        const std::uint32_t bodies = scene.bodies.size;
        const stages::LinkPair link{scene.bodies, scene.ids, view_of(last_pair_keys_), view_of(last_identities_)};
        if (!E::runs_on_host && bodies <= constants::few_bodies)
            return executor_.emit("find_pairs", Count{bodies * bodies}, stages::FindPairs{link}, pair_keys_, pairs_,
                                  identities_, links_);
        sweep(scene.bodies);
        const Count total = count_of(pair_keys_);
        pairs_.resize(total);
        identities_.resize(total);
        links_.resize(total);
        executor_.for_each(
            "link_pair", total,
            stages::LinkSorted{link, view_of(pair_keys_), view_of(pairs_), view_of(identities_), view_of(links_)});
    }

    void sweep(View<const BodyView> bodies) {
        unsorted_keys_.resize(bodies.size);
        unsorted_.resize(bodies.size);
        sweep_.resize(bodies.size);
        executor_.for_each("sweep_key", bodies.size, stages::SweepKey{bodies, view_of(unsorted_keys_), view_of(unsorted_)});
        tools_.sort("sweep_sort", stages::sweep_key_bits, unsorted_keys_, unsorted_, keys_, order_);
        executor_.for_each("gather_sweep", bodies.size, stages::GatherSweep{bodies, view_of(order_), view_of(sweep_)});
        const std::uint32_t walks = E::runs_on_host ? 1 : constants::sweep_walks;
        executor_.emit("sweep", Count{bodies.size * walks}, stages::SweepPairs{view_of(sweep_), walks}, box_keys_);
        executor_.emit("test_pair", count_of(box_keys_), stages::TestPair{bodies, view_of(box_keys_)}, unsorted_keys_);
        unsorted_.resize(count_of(unsorted_keys_));
        tools_.sort("pair_sort", 32 + std::bit_width(bodies.size), unsorted_keys_, unsorted_, pair_keys_, order_);
    }

    // Stage 3. How far pairs have moved.
    void displacement(const Scene& scene) {
        const Count directed_count = 2 * count_of(pairs_);
        memory_.resize(directed_count);
        executor_.for_each("measure_displacement", directed_count,
                           stages::MeasureDisplacement{scene.bodies, view_of(pairs_), view_of(links_), view_of(last_memory_),
                                                       scene.settings, view_of(memory_)});
    }

    // Stage 4. Patches, then vertices, that may be inside the other body.
    void vertex_cull(const Scene& scene) {
        const View<const BodyView> bodies = scene.bodies;
        const Temporal temporal = scene.plan->temporal;
        const Count directed_count = 2 * count_of(pairs_);
        directed_.resize(directed_count);
        block_offsets_.resize(directed_count);
        executor_.emit("direct_pair", directed_count,
                       stages::DirectPair{bodies, view_of(pairs_), view_of(links_), view_of(memory_), view_of(last_memory_),
                                          scene.settings, view_of(directed_), view_of(block_offsets_)},
                       blocks_);
        const bool remembers = temporal != Temporal::off;
        if (remembers) block_records_.resize(count_of(blocks_));
        share_out(count_of(blocks_), [&](auto share, Count blocks) {
            executor_.emit("cull_block", blocks,
                           stages::CullBlock<decltype(share)>{bodies, view_of(directed_), view_of(blocks_), temporal, last_,
                                                              view_of(block_records_)},
                           patches_);
        });
        if (remembers) patch_records_.resize(count_of(patches_));
        share_out(count_of(patches_), [&](auto share, Count patches) {
            const stages::CullVertices<decltype(share)> vertices{bodies,
                                                                 view_of(directed_),
                                                                 view_of(patches_),
                                                                 temporal,
                                                                 last_,
                                                                 view_of(links_),
                                                                 view_of(last_contact_keys_),
                                                                 view_of(block_offsets_),
                                                                 view_of(block_records_),
                                                                 view_of(patch_records_)};
            if (remembers)
                executor_.emit("cull_vertices", patches, vertices, batch_.sources, routes_, records_);
            else
                executor_.emit("cull_vertices", patches, vertices, batch_.sources);
        });
    }

    /// A stage of groups of sixteen; of few groups, its items see to one of the sixteen each.
    template <class Stage>
    void share_out(const Count& groups, const Stage& stage) {
        if (executor_.are_few_sixteens(groups))
            stage(OneOfSixteen{}, executor_.in_sixteens(groups));
        else
            stage(AllOfSixteen{}, groups);
    }

    // Stage 5. A ray per vertex left, or what stands in for it.
    void ray_gen(const Scene& scene) {
        const Count count = count_of(batch_.sources);
        batch_.rays.resize(count);
        batch_.hits.resize(count);
        executor_.for_each(
            "generate_rays", count,
            stages::GenerateRay{scene.bodies, view_of(directed_), view_of(batch_.sources), scene.settings, view_of(records_),
                                view_of(batch_.rays), view_of(batch_.hits), view_of(routes_)});
    }

    // Stage 6. Walks; the lost ones join the full rays.
    void walk(const Scene& scene) {
        const Count walks =
            tools_.list("walk_list", count_of(batch_.rays), stages::HasRoute{view_of(routes_), Route::walk}, walk_slots_);
        walk_counts_.resize(walks);
        found_.resize(count_of(batch_.rays));
        batch_.meetings.resize(count_of(batch_.rays));
        executor_.for_each(
            "walk", walks,
            stages::Walk{scene.bodies, view_of(directed_), view_of(batch_.rays), view_of(batch_.sources),
                         view_of(walk_slots_), scene.plan->temporal, view_of(batch_.hits), view_of(routes_),
                         view_of(records_), view_of(found_), view_of(batch_.meetings), view_of(walk_counts_)});
        const Count full =
            tools_.list("full_list", count_of(batch_.rays), stages::HasRoute{view_of(routes_), Route::full}, full_slots_);
        full_rays_.resize(full);
        executor_.for_each("gather_rays", full,
                           stages::Gather<Ray>{view_of(batch_.rays), view_of(full_slots_), view_of(full_rays_)});
    }

    void scatter_hits() {
        executor_.for_each("scatter_hits", count_of(full_slots_),
                           stages::Scatter<Hit>{view_of(full_hits_), view_of(full_slots_), view_of(batch_.hits)});
    }

    void relate_to_layers(View<const BodyView> bodies) {
        executor_.for_each("relate_to_layer", count_of(batch_.rays),
                           stages::RelateToLayer{bodies, view_of(directed_), view_of(batch_.sources), view_of(batch_.rays),
                                                 view_of(batch_.hits)});
    }

    // Stage 9, first half. R1: which rays start inside their target.
    void test_inside(const Scene& scene) {
        const Count count = count_of(batch_.rays);
        batch_.meetings.resize(count);
        const stages::TestInside inside{scene.bodies, view_of(batch_.rays), view_of(batch_.hits), view_of(routes_),
                                        view_of(batch_.meetings)};
        if (scene.plan->traces_own_exits)
            executor_.emit("test_inside", count,
                           stages::GenerateOwnRays{inside, view_of(pairs_), edges_.chords(), view_of(batch_.sources)},
                           batch_.candidates, own_rays_, starts_inside_);
        else
            executor_.emit("test_inside", count, inside, batch_.candidates);
    }

    // Stage 9, second half. R2 and R3: which of them are contacts.
    stages::TestOwnExit own_exit_test(View<const BodyView> bodies) {
        return {bodies,
                view_of(batch_.rays),
                view_of(batch_.meetings),
                view_of(batch_.candidates),
                view_of(own_rays_),
                view_of(own_hits_),
                view_of(starts_inside_),
                view_of(batch_.keep)};
    }

    /// Contacts move to the closest point of the target's surface.
    void reproject(const Scene& scene) {
        const Count count = count_of(batch_.candidates);
        aimed_.rays.resize(count);
        aimed_.hits.resize(count);
        aimed_.meetings.resize(count);
        accepted_.resize(count);
        executor_.for_each("limit_to_depth", count,
                           stages::LimitToDepth{scene.bodies, view_of(batch_.rays), view_of(batch_.sources),
                                                view_of(batch_.meetings), view_of(batch_.candidates), view_of(batch_.keep),
                                                view_of(aimed_.rays), view_of(pairs_), scene.settings.reproject});
        tools_.update(scene.bodies, aimed_.rays);
        tools_.closest("closest", scene.bodies, aimed_.rays, closest_);
        executor_.for_each("move_to_closest", count,
                           stages::MoveToClosest{scene.bodies, view_of(closest_), view_of(aimed_.rays), view_of(aimed_.hits),
                                                 view_of(aimed_.meetings), view_of(accepted_)});
    }

    // Stage 10. The list, in (pair, side, vertex) order. Candidates are tested on the way, unless they were.
    void contacts(const Scene& scene, bool tested) {
        const Count candidates = count_of(batch_.candidates);
        const stages::KeyContacts keys{edges_.chords(), view_of(batch_.sources), view_of(batch_.candidates),
                                       view_of(batch_.keep)};
        if (tested)
            executor_.emit("key_contacts", candidates, keys, unsorted_keys_, unsorted_);
        else
            executor_.emit("key_contacts", candidates, FindAfter(own_exit_test(scene.bodies), keys), unsorted_keys_,
                           unsorted_);
        const int bits = 32 + std::bit_width(static_cast<std::uint32_t>(pairs_.size()));
        tools_.sort("contact_sort", bits, unsorted_keys_, unsorted_, contact_keys_, order_);
        const Count total = count_of(contact_keys_);
        if (scene.plan->coverage == Coverage::complete)
            executor_.for_each("order_chords", total,
                               stages::OrderChords{.sources = view_of(batch_.sources),
                                                   .candidates = view_of(batch_.candidates),
                                                   .keys = view_of(contact_keys_),
                                                   .order = view_of(order_)});
        ages_.resize(total);
        contacts_.resize(total);
        executor_.reduce("fill_contact", total,
                         stages::FillContact{scene.bodies,
                                             scene.ids,
                                             view_of(pairs_),
                                             edges_.chords(),
                                             view_of(batch_.sources),
                                             batch_.results(),
                                             aimed_.results(),
                                             view_of(accepted_),
                                             view_of(batch_.candidates),
                                             view_of(order_),
                                             view_of(contact_keys_),
                                             view_of(routes_),
                                             view_of(found_),
                                             view_of(links_),
                                             view_of(last_contact_keys_),
                                             view_of(last_ages_),
                                             view_of(std::as_const(last_contacts_)),
                                             view_of(records_),
                                             view_of(ages_),
                                             view_of(contacts_)},
                         contact_sums_);
    }

    // Stage 11. What the next step needs to know.
    void remember(const Scene& scene) {
        const Count full = count_of(full_slots_);
        executor_.for_each("remember", full,
                           stages::Remember{scene.bodies, view_of(directed_), view_of(batch_.rays), view_of(batch_.sources),
                                            scene.plan->temporal, view_of(batch_.hits), view_of(batch_.meetings),
                                            view_of(full_slots_), view_of(records_)});
        uncertain_.clear();
        if (scene.plan->temporal != Temporal::certified) return;

        const Count uncertain =
            tools_.list("uncertain_list", full,
                        stages::IsUncertain{scene.bodies, view_of(directed_), view_of(batch_.rays), view_of(batch_.sources),
                                            view_of(batch_.hits), view_of(full_slots_), view_of(records_)},
                        uncertain_);
        full_rays_.resize(uncertain);
        executor_.for_each("prolong_rays", uncertain,
                           stages::ProlongRay{scene.bodies, view_of(batch_.rays), view_of(full_slots_), view_of(uncertain_),
                                              view_of(full_rays_)});
        tools_.update(scene.bodies, full_rays_);
        tools_.trace("prove", scene.bodies, full_rays_, full_hits_);
        executor_.for_each("limit_to_certificate", uncertain,
                           stages::LimitToCertificate{scene.bodies, view_of(full_hits_), view_of(full_rays_)});
        tools_.closest("closest", scene.bodies, full_rays_, closest_);
        executor_.for_each("certify", uncertain,
                           stages::Certify{scene.bodies, view_of(directed_), view_of(batch_.sources), view_of(full_slots_),
                                           view_of(uncertain_), view_of(full_rays_), view_of(closest_), view_of(records_)});
    }

    // Stage 12. What the step did.
    void count(const Plan& plan) {
        if (plan.sheets) sheets_.add_up(sheet_sums_);
        if (plan.temporal == Temporal::off) return;
        executor_.reduce("count_walks", count_of(walk_counts_), stages::CountWalk{view_of(walk_counts_)}, walk_sums_);
        executor_.reduce("count_skipped", count_of(routes_), stages::CountSkipped{view_of(routes_)}, skipped_sum_);
        executor_.reduce("count_predicted", count_of(records_), stages::CountPredicted{view_of(records_)}, predicted_sum_);
        executor_.reduce("count_full_passes", count_of(pairs_), stages::CountFullPass{view_of(memory_)}, full_pass_sum_);
    }

    void count_rays() {
        executor_.reduce("count_hits", count_of(batch_.hits), stages::CountHit{view_of(batch_.hits)}, hit_sum_);
        executor_.reduce("count_own_rays", count_of(own_rays_), stages::CountTraced{view_of(own_rays_)}, own_ray_sum_);
    }

    E& executor_;
    T& tracer_;
    StepTools<E, T> tools_;
    EdgeChords<E, T> edges_;
    SelfOverlap<E, T> self_overlap_;
    Separation<E, T> separation_;
    Sheets<E, T> sheets_;

    Buffer<stages::Moments> moments_;
    Buffer<stages::PartBounds> block_bounds_;
    Buffer<std::uint64_t> unsorted_keys_, keys_, box_keys_, pair_keys_, last_pair_keys_, contact_keys_, last_contact_keys_;
    Buffer<std::uint32_t> unsorted_, order_, starts_inside_, accepted_, links_, ages_, last_ages_;
    Buffer<stages::SweepItem> sweep_;
    Buffer<Pair> pairs_;
    Buffer<PairIdentity> identities_, last_identities_;
    Buffer<stages::DirectedPair> directed_;
    Buffer<stages::CullItem> blocks_, patches_;
    Buffer<std::uint32_t> block_offsets_;
    RayBatch<E> batch_, aimed_;
    Buffer<Ray> own_rays_, full_rays_;
    Buffer<Hit> own_hits_, full_hits_;
    Buffer<Route> routes_;
    Buffer<Found> found_;
    Buffer<std::uint32_t> walk_slots_, full_slots_, uncertain_, closest_;
    Buffer<stages::WalkCount> walk_counts_;
    Buffer<Contact> contacts_, last_contacts_;
    Sum<stages::ContactSums> contact_sums_, sheet_sums_;
    Sum<stages::WalkSums> walk_sums_;
    Sum<std::uint32_t> hit_sum_, own_ray_sum_, skipped_sum_, predicted_sum_, full_pass_sum_;

    TracerCounts reported_;

    // What steps remember, and last step's.
    Buffer<SeenBody> seen_bodies_, last_seen_bodies_;
    Buffer<PairMemory> memory_, last_memory_;
    Buffer<BlockRecord> block_records_, last_block_records_;
    Buffer<PatchRecord> patch_records_, last_patch_records_;
    Buffer<VertexRecord> records_, last_records_;
    RecordsView last_;
};

}  // namespace pierce
