#include "app/output/picture.hpp"

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <vector>

#include "core/base/whole_file.hpp"
#include "pierce/error.hpp"

namespace pierce::app {
namespace {

constexpr int width = 960, height = 600;
constexpr double field_of_view = 0.6;  // [rad] vertical
constexpr Vec3d ground_color{0.86, 0.87, 0.88}, sky_color{0.97, 0.98, 1.0},
    calm_color{0.62, 0.66, 0.72};
constexpr Vec3d shallow_color{1.0, 0.80, 0.20}, deep_color{0.80, 0.05, 0.10},
    contact_color{0.05, 0.20, 0.75};
constexpr int dot_radius = 2;  // [pixels]

Vec3d mix(Vec3d a, Vec3d b, double part) { return (1 - part) * a + part * b; }

struct Camera {
    Vec3d eye, forward, right, up;

    /// Looks at the middle of `box` from the front, a little from above.
    explicit Camera(const Box& box) {
        forward = normalized(Vec3d{-0.35, 0.9, -0.35});
        right = normalized(cross(forward, Vec3d{0, 0, 1}));
        up = cross(right, forward);
        eye = box.center() - (0.42 * box.extent() / std::tan(field_of_view / 2)) * forward;
    }

    Vec3d direction(int x, int y) const {
        const double scale = 2 * std::tan(field_of_view / 2) / height;
        return forward + (scale * (x + 0.5 - width / 2.0)) * right +
               (scale * (height / 2.0 - y - 0.5)) * up;
    }

    /// The pixel that shows a point; outside of the picture or behind the camera, none.
    std::optional<std::array<int, 2>> pixel(Vec3d point) const {
        const Vec3d way = point - eye;
        const double away = dot(way, forward);
        if (!(away > 0)) return std::nullopt;
        const double scale = height / (2 * std::tan(field_of_view / 2) * away);
        const double x = width / 2.0 + scale * dot(way, right),
                     y = height / 2.0 - scale * dot(way, up);
        if (!(x >= 0 && x < width && y >= 0 && y < height)) return std::nullopt;
        return std::array{static_cast<int>(x), static_cast<int>(y)};
    }
};

/// A dot around a pixel.
void mark(std::vector<png_byte>& pixels, std::array<int, 2> at) {
    for (int y = -dot_radius; y <= dot_radius; ++y)
        for (int x = -dot_radius; x <= dot_radius; ++x) {
            const int column = at[0] + x, row = at[1] + y;
            if (x * x + y * y > dot_radius * dot_radius || column < 0 || column >= width ||
                row < 0 || row >= height)
                continue;
            const auto first = static_cast<std::ptrdiff_t>(row) * width + column;
            png_byte* const pixel = pixels.data() + 3 * first;
            for (int k = 0; k < 3; ++k)
                pixel[k] = static_cast<png_byte>(std::lround(255 * contact_color[k]));
        }
}

}  // namespace

std::vector<BodyId> ground_of(const scenes::SceneSetup& scene) {
    // A World gives out handles in order, and a scene never removes a body.
    std::vector<BodyId> ground;
    for (std::uint32_t b = 0; b < scene.bodies.size(); ++b)
        if (scene.bodies[b].ground) ground.push_back({b, 1});
    return ground;
}

Box box_of_bodies(const World& world, std::span<const BodyId> ground) {
    Box box, of_ground;
    for (const World::BodyBox& b : world.body_boxes())
        (std::ranges::find(ground, b.body) == ground.end() ? box : of_ground).extend(b.box);
    if (!box.empty()) return box;
    return of_ground.empty() ? Box{{-1, -1, -1}, {1, 1, 1}} : of_ground;
}

void write_picture(World& world, std::span<const BodyId> ground, const Shot& shot,
                   const std::filesystem::path& file) {
    const auto is_ground = [&](BodyId body) {
        return std::ranges::find(ground, body) != ground.end();
    };

    std::unordered_map<BodyId, double> depth;
    double deepest = 0;
    for (const Contact& c : world.contacts()) {
        for (BodyId body : {c.a, c.b}) depth[body] = std::max(depth[body], c.penetration_depth());
        deepest = std::max(deepest, c.penetration_depth());
    }
    if (shot.deepest > 0) deepest = shot.deepest;

    const Camera camera(shot.around);
    std::vector<Vec3d> directions;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) directions.push_back(camera.direction(x, y));
    const auto hits = world.cast_rays(camera.eye, directions);

    const Vec3d light = normalized(Vec3d{-0.4, -0.6, 1.0});
    std::vector<png_byte> pixels;
    for (const auto& hit : hits) {
        Vec3d color = sky_color;
        if (hit) {
            const bool touches = depth.contains(hit->body);
            color = is_ground(hit->body) ? ground_color
                    : !touches           ? calm_color
                                         : mix(shallow_color, deep_color,
                                     deepest > 0 ? std::min(depth[hit->body] / deepest, 1.0) : 0);
            color = (0.35 + 0.65 * std::max(dot(hit->normal, light), 0.0)) * color;
        }
        for (int k = 0; k < 3; ++k)
            pixels.push_back(
                static_cast<png_byte>(std::lround(255 * std::clamp(color[k], 0.0, 1.0))));
    }

    if (shot.contacts)
        for (const Contact& c : world.contacts())
            if (const auto at = camera.pixel(c.point_b)) mark(pixels, *at);

    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = width;
    image.height = height;
    image.format = PNG_FORMAT_RGB;
    // Into memory first: libpng removes a file that it cannot write, also if that is a device.
    png_alloc_size_t size = 0;
    if (png_image_write_get_memory_size(image, size, 0, pixels.data(), 0, nullptr) == 0)
        throw InputError("cannot write '" + file.string() + "': " + image.message);
    std::string content(size, '\0');
    if (png_image_write_to_memory(&image, content.data(), &size, 0, pixels.data(), 0, nullptr) == 0)
        throw InputError("cannot write '" + file.string() + "': " + image.message);
    content.resize(size);
    write_whole_file(file, [&](std::ostream& out) { out << content; });
}

}  // namespace pierce::app
