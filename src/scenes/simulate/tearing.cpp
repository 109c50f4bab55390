#include "scenes/simulate/tearing.hpp"

#include <algorithm>
#include <utility>

#include "pierce/bullet/bullet_convert.hpp"
#include "scenes/simulate/sheet_crossings.hpp"

namespace pierce::scenes {
namespace {

/// The part of the way to its neighbours by which a torn node is drawn back; where it would pass
/// through another triangle, half of it, and so on.
constexpr btScalar drawn_back = btScalar(0.15);
constexpr int halvings = 4;

}  // namespace

Tearing::Tearing(btSoftBody& soft, MeshData mesh, const TearSettings& settings)
    : soft_(soft), mesh_(std::move(mesh)), settings_(settings) {
    find_triangles();
}

void Tearing::find_triangles() {
    triangles_of_.assign(mesh_.positions.size(), {});
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
        for (std::uint32_t v : mesh_.triangles[t].vertex) triangles_of_[v].push_back(t);
}

/// True if a triangle has both vertices.
bool Tearing::is_edge(std::uint32_t a, std::uint32_t b) const {
    return std::ranges::any_of(triangles_of_[a], [&](std::uint32_t t) {
        return std::ranges::find(mesh_.triangles[t].vertex, b) !=
               std::end(mesh_.triangles[t].vertex);
    });
}

/// True if a vertex has edges to both.
bool Tearing::share_neighbor(std::uint32_t a, std::uint32_t b) const {
    for (std::uint32_t t : triangles_of_[a])
        for (std::uint32_t v : mesh_.triangles[t].vertex)
            if (v != a && v != b && is_edge(v, b)) return true;
    return false;
}

/// A vertex and those to which it has an edge.
Tearing::Vertices Tearing::around(std::uint32_t vertex) const {
    Vertices all{vertex};
    for (std::uint32_t t : triangles_of_[vertex])
        all.insert(std::begin(mesh_.triangles[t].vertex), std::end(mesh_.triangles[t].vertex));
    return all;
}

std::uint32_t Tearing::tear() {
    struct Stretched {
        btScalar by;
        int link;
        std::uint32_t node[2];
        btVector3 across;
    };
    const auto node_of = [&](const btSoftBody::Node* node) {
        return static_cast<std::uint32_t>(node - &soft_.m_nodes[0]);
    };
    std::vector<Stretched> stretched;
    for (int l = 0; l < soft_.m_links.size(); ++l) {
        const btSoftBody::Link& link = soft_.m_links[l];
        const btVector3 way = link.m_n[1]->m_x - link.m_n[0]->m_x;
        const btScalar by = way.length() / link.m_rl;
        const std::uint32_t a = node_of(link.m_n[0]), b = node_of(link.m_n[1]);
        if (by > static_cast<btScalar>(settings_.limit) && is_edge(a, b))
            stretched.push_back({.by = by, .link = l, .node = {a, b}, .across = way.normalized()});
    }
    std::ranges::sort(stretched, [](const Stretched& a, const Stretched& b) {
        return a.by > b.by || (a.by == b.by && a.link < b.link);
    });

    // What is near a new tear is relieved by it, and must show its stretch anew.
    Vertices done;
    std::uint32_t count = 0;
    for (const Stretched& s : stretched) {
        if (count == settings_.most_at_once) break;
        const bool is_near = std::ranges::any_of(s.node, [&](std::uint32_t n) {
            return std::ranges::any_of(around(n),
                                       [&](std::uint32_t v) { return done.contains(v); });
        });
        if (is_near) continue;
        for (std::uint32_t n : s.node) {
            if (!split(n, s.across)) continue;
            done.insert({n, static_cast<std::uint32_t>(mesh_.positions.size() - 1)});
            ++count;
            break;
        }
    }
    if (count > 0) {
        // Otherwise Bullet would take the links' present lengths as their rest lengths.
        soft_.m_bUpdateRtCst = false;
        soft_.updateLinkConstants();
        soft_.updateArea();
        soft_.updateNormals();
    }
    return count;
}

/// True if enough triangles would hang together with a part of a node's triangles, were the node
/// split.
bool Tearing::hangs_together(std::uint32_t node, const Triangles& part) const {
    Triangles found = part;
    std::set<std::uint32_t> seen(part.begin(), part.end());
    for (std::size_t k = 0; k < found.size() && found.size() < settings_.least_part; ++k)
        for (std::uint32_t v : mesh_.triangles[found[k]].vertex) {
            if (v == node) continue;
            for (std::uint32_t t : triangles_of_[v])
                if (seen.insert(t).second) found.push_back(t);
        }
    return found.size() >= settings_.least_part;
}

/// Splits a node along the plane across a direction; false if it is led, if all its triangles are
/// on one side, or if too small a part would come off.
bool Tearing::split(std::uint32_t node, btVector3 across) {
    const btVector3 at = soft_.m_nodes[static_cast<int>(node)].m_x;
    if (soft_.m_nodes[static_cast<int>(node)].m_im <= 0) return false;
    Triangles beyond, rest;
    for (std::uint32_t t : triangles_of_[node]) {
        btVector3 sum(0, 0, 0);
        for (std::uint32_t v : mesh_.triangles[t].vertex)
            sum += soft_.m_nodes[static_cast<int>(v)].m_x - at;
        (sum.dot(across) > 0 ? beyond : rest).push_back(t);
    }
    if (beyond.empty() || rest.empty() || !hangs_together(node, beyond) ||
        !hangs_together(node, rest))
        return false;

    Vertices nearby;
    for (std::uint32_t v : around(node)) nearby.merge(around(v));
    const double share = static_cast<double>(beyond.size()) /
                         static_cast<double>(triangles_of_[node].size());
    const std::uint32_t other = add_node(node, share);
    for (std::uint32_t t : beyond)
        for (int k = 0; k < 3; ++k) {
            if (mesh_.triangles[t].vertex[k] != node) continue;
            mesh_.triangles[t].vertex[k] = other;
            soft_.m_faces[static_cast<int>(t)].m_n[k] = &soft_.m_nodes[static_cast<int>(other)];
        }
    find_triangles();
    divide_links(node, other, nearby, across);
    draw_back(node);
    draw_back(other);
    return true;
}

/// How often the surface goes through itself.
std::uint32_t Tearing::crossings() const {
    std::vector<Vec3f> positions;
    for (int i = 0; i < soft_.m_nodes.size(); ++i)
        positions.push_back(bullet::from_bullet_float(soft_.m_nodes[i].m_x));
    return self_crossings(mesh_.triangles, positions).count;
}

/// Draws a part of a node back into its own triangles, so that the two parts do not touch. It stays
/// where it is if it would pass through another triangle however little it is drawn.
void Tearing::draw_back(std::uint32_t node) {
    btVector3 sum(0, 0, 0);
    const Vertices all = around(node);
    for (std::uint32_t v : all) sum += soft_.m_nodes[static_cast<int>(v)].m_x;
    btVector3& at = soft_.m_nodes[static_cast<int>(node)].m_x;
    const btVector3 torn = at, middle = sum / static_cast<btScalar>(all.size());
    const std::uint32_t before = crossings();
    btScalar share = drawn_back;
    for (int k = 0; k <= halvings; ++k, share /= 2) {
        at = torn.lerp(middle, share);
        if (crossings() <= before) return;
    }
    at = torn;
}

/// A node that takes a share of another one's mass.
std::uint32_t Tearing::add_node(std::uint32_t node, double share) {
    const auto n = static_cast<int>(node);
    const btScalar mass = 1 / soft_.m_nodes[n].m_im, part = static_cast<btScalar>(share) * mass;
    soft_.appendNode(soft_.m_nodes[n].m_x, part);
    btSoftBody::Node &old = soft_.m_nodes[n], &made = soft_.m_nodes[soft_.m_nodes.size() - 1];
    old.m_im = 1 / (mass - part);
    made.m_v = old.m_v;
    made.m_q = old.m_q;
    if (soft_.m_pose.m_bframe) {
        // The parts are no longer drawn back to one shape.
        soft_.m_pose.m_bframe = false;
        soft_.m_cfg.kMT = 0;
    }
    mesh_.positions.push_back(mesh_.positions[node]);
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
}

/// Gives each part of a node the links to the vertices on its side, and removes links between
/// vertices that are no longer near each other along the surface. `nearby`: vertices that were
/// within two edges of the node.
void Tearing::divide_links(std::uint32_t node, std::uint32_t other, const Vertices& nearby,
                           btVector3 across) {
    const auto at = [&](std::uint32_t v) -> btSoftBody::Node& {
        return soft_.m_nodes[static_cast<int>(v)];
    };
    const auto node_of = [&](const btSoftBody::Node* n) {
        return static_cast<std::uint32_t>(n - &soft_.m_nodes[0]);
    };
    struct Copy {
        std::uint32_t end;
        btScalar rest_length;
        btSoftBody::Material* material;
    };
    Vertices next = around(node);
    next.merge(around(other));
    std::vector<Copy> copies;
    for (int l = soft_.m_links.size() - 1; l >= 0; --l) {
        btSoftBody::Link& link = soft_.m_links[l];
        const std::uint32_t a = node_of(link.m_n[0]), b = node_of(link.m_n[1]);
        if (a != node && b != node) {
            // Only vertices around the node can have lost the neighbour that they shared.
            if (!next.contains(a) || !next.contains(b) || is_edge(a, b) || share_neighbor(a, b))
                continue;
            soft_.m_links.swap(l, soft_.m_links.size() - 1);
            soft_.m_links.pop_back();
            continue;
        }
        const std::uint32_t end = a == node ? b : a;
        const bool stays_edge = is_edge(node, end), goes_edge = is_edge(other, end);
        if (stays_edge && goes_edge) {
            copies.push_back({end, link.m_rl, link.m_material});
            continue;
        }
        // A strut stays on its side.
        const bool is_strut = !nearby.contains(end);
        const bool stays = stays_edge || is_strut || share_neighbor(node, end),
                   goes = goes_edge || is_strut || share_neighbor(other, end);
        const bool is_beyond = (at(end).m_x - at(node).m_x).dot(across) > 0;
        if (!stays_edge && (goes_edge || (goes && (!stays || is_beyond))))
            link.m_n[a == node ? 0 : 1] = &at(other);
        else if (!stays) {
            soft_.m_links.swap(l, soft_.m_links.size() - 1);
            soft_.m_links.pop_back();
        }
    }
    for (const Copy& copy : copies) {
        soft_.appendLink(&at(other), &at(copy.end), copy.material);
        soft_.m_links[soft_.m_links.size() - 1].m_rl = copy.rest_length;
    }
}

}  // namespace pierce::scenes
