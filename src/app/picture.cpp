#include "app/picture.hpp"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <vector>

#include "pierce/error.hpp"

namespace pierce::app {
namespace {

constexpr int width = 960, height = 600;
constexpr double field_of_view = 0.6;  // [rad] vertical
constexpr Vec3d ground_color{0.86, 0.87, 0.88}, sky_color{0.97, 0.98, 1.0},
    calm_color{0.62, 0.66, 0.72};
constexpr Vec3d shallow_color{1.0, 0.80, 0.20}, deep_color{0.80, 0.05, 0.10};

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
};

}  // namespace

void write_picture(World& world, std::span<const BodyId> ground,
                   const std::filesystem::path& file) {
    const auto is_ground = [&](BodyId body) {
        return std::ranges::find(ground, body) != ground.end();
    };
    Box box;
    for (const World::BodyBox& b : world.body_boxes())
        if (!is_ground(b.body)) box.extend(b.box);

    std::unordered_map<BodyId, double> depth;
    double deepest = 0;
    for (const Contact& c : world.contacts()) {
        for (BodyId body : {c.a, c.b}) depth[body] = std::max(depth[body], c.penetration_depth());
        deepest = std::max(deepest, c.penetration_depth());
    }

    const Camera camera(box);
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
                                     deepest > 0 ? depth[hit->body] / deepest : 0);
            color = (0.35 + 0.65 * std::max(dot(hit->normal, light), 0.0)) * color;
        }
        for (int k = 0; k < 3; ++k)
            pixels.push_back(
                static_cast<png_byte>(std::lround(255 * std::clamp(color[k], 0.0, 1.0))));
    }

    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = width;
    image.height = height;
    image.format = PNG_FORMAT_RGB;
    if (png_image_write_to_file(&image, file.c_str(), 0, pixels.data(), 0, nullptr) == 0)
        throw InputError("cannot write '" + file.string() + "': " + image.message);
}

}  // namespace pierce::app
