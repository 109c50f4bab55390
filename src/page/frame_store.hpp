#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <unordered_map>
#include <vector>

#include "page/packed_arrays.hpp"
#include "page/reasons.hpp"
#include "pierce/world.hpp"

namespace pierce::page {

/// Bodies, contacts and reasons of all frames of a page, as columns of numbers.
class FrameStore {
public:
    /// Keeps a world after a step. `names`: of bodies; those without have their mesh's. `reasons`:
    /// also why vertices have no contact.
    void add(World& world, const std::map<BodyId, std::string>& names, bool reasons);
    std::uint32_t frame_count() const { return static_cast<std::uint32_t>(frames_.size()); }

    /// Adds all columns to `arrays`, and what describes them to `description`. Numbers are rounded
    /// if the page would be too large otherwise; `description["rounded"]` says so.
    void pack(PackedArrays& arrays, nlohmann::json& description) const;

private:
    struct Body {
        std::string name;
        Motion motion = Motion::rigid;
        bool sheet = false;
    };
    /// A mesh, with the numbers that go into the page.
    struct MeshArrays {
        std::string name;
        bool closed = true;
        std::vector<float> vertices;
        std::vector<std::uint32_t> triangles;
        std::vector<std::uint32_t> patches;  ///< per vertex
    };
    /// Where a body is in a frame: seven numbers of a pose, or three per vertex.
    struct Place {
        std::uint32_t body = 0, mesh = 0;
        bool left_out = false;  ///< of the step
        std::vector<float> numbers = {};
    };
    struct Frame {
        std::vector<Place> places;
        std::vector<Contact> contacts;
        std::vector<VertexReason> reasons;
    };

    std::uint32_t number_of(const World& world, BodyId body,
                            const std::map<BodyId, std::string>& names);
    std::uint32_t number_of_mesh(const World& world, MeshId mesh);
    std::uint32_t number(BodyId body) const { return body_numbers_.at(body); }
    bool is_rounded() const;
    void pack_meshes(PackedArrays& arrays, nlohmann::json& description) const;
    void pack_places(PackedArrays& arrays, nlohmann::json& description, bool rounded) const;
    void pack_contacts(PackedArrays& arrays, bool rounded) const;
    void pack_reasons(PackedArrays& arrays, nlohmann::json& description, bool rounded) const;

    std::vector<Body> bodies_;
    std::vector<MeshArrays> meshes_;
    std::unordered_map<BodyId, std::uint32_t> body_numbers_;
    std::unordered_map<MeshId, std::uint32_t> mesh_numbers_;
    std::vector<Frame> frames_;
    bool has_all_reasons_ = true;
};

}  // namespace pierce::page
