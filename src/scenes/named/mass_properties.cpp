#include "scenes/named/mass_properties.hpp"

#include <Eigen/Eigenvalues>

#include "pierce/error.hpp"

namespace pierce::scenes {

double volume_of(const MeshData& mesh, const std::function<Vec3d(std::uint32_t)>& position) {
    double volume = 0;
    const Vec3d base = position(0);
    for (const Triangle& t : mesh.triangles)
        volume += dot(position(t.vertex[0]) - base,
                      cross(position(t.vertex[1]) - base, position(t.vertex[2]) - base)) /
                  6;
    return volume;
}

MassProperties mass_properties(const MeshData& mesh) {
    Vec3d reference;
    for (Vec3f p : mesh.positions) reference += to_double(p);
    reference = reference * (1.0 / static_cast<double>(mesh.positions.size()));

    double volume = 0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (const Triangle& t : mesh.triangles) {
        Eigen::Vector3d corner[3];
        for (int k = 0; k < 3; ++k) {
            const Vec3d p = to_double(mesh.positions[t.vertex[k]]) - reference;
            corner[k] = {p.x, p.y, p.z};
        }
        const double v = corner[0].dot(corner[1].cross(corner[2])) / 6;
        const Eigen::Vector3d sum = corner[0] + corner[1] + corner[2];
        volume += v;
        first += v / 4 * sum;
        for (const Eigen::Vector3d& c : corner) second += v / 20 * c * c.transpose();
        second += v / 20 * sum * sum.transpose();
    }
    if (!(volume > 0)) throw InputError("a solid needs a closed mesh of positive volume");
    const Eigen::Vector3d center = first / volume;
    const Eigen::Matrix3d moments = second - volume * center * center.transpose();
    const Eigen::Matrix3d inertia = moments.trace() * Eigen::Matrix3d::Identity() - moments;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
    Eigen::Matrix3d axes = solver.eigenvectors().transpose();
    if (axes.determinant() < 0) axes.row(2) *= -1;

    MassProperties properties;
    properties.mass = volume;
    properties.center = reference + Vec3d{center.x(), center.y(), center.z()};
    properties.inertia = {solver.eigenvalues()[0], solver.eigenvalues()[1],
                          solver.eigenvalues()[2]};
    for (int r = 0; r < 3; ++r)
        properties.principal_axes.row[r] = {axes(r, 0), axes(r, 1), axes(r, 2)};
    return properties;
}

Frame to_principal_frame(MeshData& mesh) {
    const MassProperties properties = mass_properties(mesh);
    const Frame moved{properties.principal_axes,
                      -1.0 * (properties.principal_axes * properties.center)};
    for (Vec3f& p : mesh.positions) p = to_float(moved.to_parent(to_double(p)));
    return moved;
}

}  // namespace pierce::scenes
