// Solids composed of fields: against analytic ones, against the tree of the exact splines along
// each ray, and against each other.
// SPDX-License-Identifier: MPL-2.0
#include "csg_trees.h"
#include "filtering/curvature.h"
#include "filtering/filter.h"
#include "filtering/reconstruct.h"
#include "raycaster/reference.h"
#include "shading_scene.h"
#include "volume/errors.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <numbers>

namespace isocast::test {
namespace {

CsgTree pair(CsgOperation operation) {
    return {{Object, 0}, {Object, 1}, {operation}};
}

/// Samples at n^3 points of a grid, with no band.
std::shared_ptr<const FieldSource> sampled_in(const GridSpace& space, int n,
                                              const AnalyticField& field) {
    const IndexBox extent{Index3::Zero(), Index3::Constant(n)};
    std::vector<float> values;
    for_each_sample(extent, [&](const Index3& i) {
        values.push_back(static_cast<float>(field.jet(space.to_world(i.cast<double>())).value));
    });
    return std::make_shared<DenseField>(space, extent, std::move(values));
}

/// A grid of n^3 voxels of random edges, turned at random, about the middle.
GridSpace random_space(Random& random, const Vec3d& middle_world, double edge_world, int n) {
    GridSpace space;
    const Mat3d turn =
        Eigen::AngleAxisd(random_real(random, 0, 3), random_point(random, -1, 1).normalized())
            .toRotationMatrix();
    const Vec3d edges = random_point(random, 0.9, 1.3) * edge_world / (n - 1);
    space.world_from_index.linear() = turn * edges.asDiagonal();
    space.world_from_index.translation() =
        middle_world - space.world_from_index.linear() * Vec3d::Constant(0.5 * (n - 1));
    return space;
}

GridSpace cube_around(const Vec3d& middle_world, double edge_world, int n) {
    return GridSpace::uniform(edge_world / (n - 1),
                              middle_world - Vec3d::Constant(0.5 * edge_world));
}

constexpr double radius = 0.8;
constexpr double apart = 0.9; // middles at x = -0.45 and 0.45
/// Where the two spheres meet: x = 0, at this distance from the x axis.
const double crease_radius = std::sqrt(radius * radius - 0.25 * apart * apart);
/// By which a hit on either may be off: fourth-order errors of the spline's value, f'''' h^4 / 192
/// a line with f'''' below 15 / r^3 and voxels of at most 2/39.
constexpr double sphere_error = 3 * 15 / (radius * radius * radius) / 192 * 6.92e-6;

FieldObject ball(double x, int n, double edge = 2) {
    const Vec3d middle(x, 0, 0);
    return {.field = sampled_in(cube_around(middle, edge, n), n, sphere_field(middle, radius))};
}

struct Csg : Shading {
    /// Two spheres on lattices that do not match.
    Scene spheres{.objects = {ball(-0.5 * apart, 40), ball(0.5 * apart, 47, 2.1)}};

    Image draw_pair(CsgOperation operation, FrameImage image = FrameImage::Hit) {
        spheres.tree = pair(operation);
        return draw(spheres, image);
    }
    void look_from(const Vec3d& direction, double height) {
        camera = {.eye_world = 5 * direction,
                  .target_world = Vec3d::Zero(),
                  .up = std::abs(direction.y()) > 0.5 ? Vec3d::UnitZ() : Vec3d::UnitY(),
                  .projection = Projection::Orthographic,
                  .height_world = height};
    }
    /// Calls visit(p_world, owner) at every hit; returns how many there are.
    template<class Visit>
    int for_each_hit(const Image& hits, Visit visit) const {
        int count = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            const float* hit = &hits.rgba[i];
            if (hit[3] == 0) continue;
            ++count;
            visit(Vec3d(camera.eye_world + Vec3d(hit[0], hit[1], hit[2])), int(hit[3]), i);
        }
        return count;
    }
};

TEST_F(Csg, OwnersOfTwoSpheresSwitchAtTheIntersectionCircle) {
    struct Case {
        CsgOperation operation;
        int owner_of_left; // at x < 0
        int owner_of_right;
        int least_hits;
    };
    for (const auto& [operation, owner_of_left, owner_of_right, least_hits] :
         {Case{Union, 1, 2, 2000}, Case{Intersection, 2, 1, 500}, Case{Difference, 0, 0, 1000}}) {
        for (const Vec3d& direction :
             {Vec3d(0, 0, 1), Vec3d(1, 0, 0), Vec3d(0.5, 0.4, 0.6).normalized().eval()}) {
            look_from(direction, 2.8);
            const Image hits = draw_pair(operation);
            const double pixel = camera.height_world / size;
            int at_crease = 0;
            const int count = for_each_hit(hits, [&](const Vec3d& p, int owner, std::size_t i) {
                const double side = owner == 1 ? -1 : 1;
                EXPECT_NEAR((p - Vec3d(0.5 * side * apart, 0, 0)).norm(), radius, sphere_error);
                // Off the crease by the spheres' errors over the sine of their angle, 0.95.
                if (operation == Difference) { // A's own part and the cut, both on the left
                    EXPECT_LT(p.x(), 1.1 * sphere_error);
                    EXPECT_TRUE(owner == 1 || owner == -2);
                } else if (std::abs(p.x()) > 1.1 * sphere_error) {
                    EXPECT_EQ(owner, p.x() < 0 ? owner_of_left : owner_of_right);
                }
                // Neighbours of two owners are at the circle, or one hides the other.
                const auto next = i + 4;
                if (next % (4 * static_cast<std::size_t>(size)) == 0 || hits.rgba[next + 3] == 0 ||
                    int(hits.rgba[next + 3]) == owner)
                    return;
                const Vec3d q(hits.rgba[next], hits.rgba[next + 1], hits.rgba[next + 2]);
                const Vec3d step = q + camera.eye_world - p;
                if (step.norm() > 3 * pixel) return;
                ++at_crease;
                // As far as the pixel's step along the spheres.
                EXPECT_LT(std::abs(p.x()), step.norm());
                EXPECT_LT(std::abs(std::hypot(p.y(), p.z()) - crease_radius), step.norm());
            });
            EXPECT_GT(count, least_hits);
            const bool shows_crease =
                operation == Difference ? direction.y() > 0 : direction.x() < 1;
            if (shows_crease) {
                EXPECT_GT(at_crease, 5);
            }
        }
    }
}

TEST_F(Csg, VolumesOfTwoSpheresAreTheAnalyticOnes) {
    const double ball_volume = 4.0 / 3 * std::numbers::pi * std::pow(radius, 3);
    const double lens =
        std::numbers::pi / 12 * (4 * radius + apart) * std::pow(2 * radius - apart, 2);
    size = 128;
    // Along z all three are as thick as they are symmetric, and rays enter them once.
    look_from({0, 0, 1}, 2.8);
    const double pixel = camera.height_world / size;
    const auto volume = [&](CsgOperation operation) {
        double sum = 0;
        for_each_hit(draw_pair(operation), [&](const Vec3d& p, int owner, std::size_t) {
            // A - B ends at B where a ray enters it through A's middle part.
            if (owner > 0) sum += 2 * p.z() * pixel * pixel;
        });
        return sum;
    };
    // Midpoint sums; at the rim, where the thickness is 2 sqrt(2 r s), 2 pi r / pixel pixels err by
    // pixel^2.5 sqrt(8 r)/3 each at most, at random: 0.1 % of a ball's volume. 0.3 %: three times.
    EXPECT_NEAR(volume(Union), 2 * ball_volume - lens, 0.003 * ball_volume);
    EXPECT_NEAR(volume(Intersection), lens, 0.003 * ball_volume);
}

TEST_F(Csg, AnObjectWithItselfIsItselfBitForBitOrNothing) {
    const FieldObject a = ball(0.1, 40);
    const Image alone = draw({.field = a.field}, FrameImage::Hit);
    const Image picture = draw({.field = a.field});
    for (const std::vector<FieldObject>& objects :
         {std::vector{a}, std::vector{a, a}, std::vector{a, a, a}}) {
        const int last = static_cast<int>(objects.size()) - 1;
        for (const CsgOperation operation : {Union, Intersection}) {
            CsgTree tree = union_of_all(last + 1);
            tree.push_back({Object, last});
            tree.push_back({operation});
            Image hits = draw({.objects = objects, .tree = tree}, FrameImage::Hit);
            for (std::size_t i = 3; i < hits.rgba.size(); i += 4)
                if (hits.rgba[i] != 0) hits.rgba[i] = 1; // either owns it
            EXPECT_EQ(hits.rgba, alone.rgba);
            EXPECT_EQ(draw({.objects = objects, .tree = tree}).rgba, picture.rgba);
        }
        CsgTree nothing = union_of_all(last + 1);
        nothing.push_back({Object, last});
        if (last == 0 || last == 1) {
            nothing = {{Object, 0}, {Object, last}, {Difference}};
            const Image hits = draw({.objects = objects, .tree = nothing}, FrameImage::Hit);
            EXPECT_EQ(for_each_hit(hits, [](const Vec3d&, int, std::size_t) {}), 0);
        }
    }
}

/// What a scene's composed function is, in double, by the splines of its objects.
class Oracle {
public:
    explicit Oracle(const Scene& scene) : scene_(scene), tree_(tree_of(scene)) {
        for (const FieldObject& object : scene.objects) {
            controls_.push_back(control_samples(object.field, object.filter));
            casters_.emplace_back(*controls_.back(), object.iso_world,
                                  ReferenceOptions{.kernel = kernel_of(object.filter)});
        }
    }
    /// Each object's value, beyond the extent that of the outside.
    std::vector<double> values(const Vec3d& p_world) const {
        std::vector<double> all;
        for (std::size_t i = 0; i < casters_.size(); ++i) {
            const FieldSource& field = *scene_.objects[i].field;
            const Vec3d p = field.space().to_index(p_world);
            const IndexBox extent = field.extent();
            const bool is_beyond = (p.array() < extent.lo.cast<double>().array()).any() ||
                                   (p.array() > extent.hi.cast<double>().array() - 1).any();
            all.push_back(is_beyond ? 1 : casters_[i].value(p));
        }
        return all;
    }
    double value(const Vec3d& p_world) const { return composed_value(tree_, values(p_world)); }
    /// The gradient of one object, world axes.
    Vec3d gradient(int object, const Vec3d& p_world) const {
        const auto i = static_cast<std::size_t>(object);
        const GridSpace& space = scene_.objects[i].field->space();
        return space.gradient_to_world(casters_[i].gradient(space.to_index(p_world)));
    }

private:
    const Scene& scene_;
    CsgTree tree_;
    std::vector<std::shared_ptr<const FieldSource>> controls_;
    std::vector<ReferenceCaster> casters_;
};

struct RandomCsg : Csg {
    static constexpr int n = 28;
    static constexpr double edge = 1.7; // of a grid, about

    /// Spheres and tori on grids of their own, all surfaces within 1.3 of the origin.
    Scene random_scene(Random& random, int object_count) {
        Scene scene;
        for (int i = 0; i < object_count; ++i) {
            const Vec3d middle = random_point(random, -0.35, 0.35);
            const GridSpace space = random_space(random, middle, edge, n);
            const AnalyticField field =
                random_int(random, 0, 1) == 0
                    ? sphere_field(middle, random_real(random, 0.35, 0.6))
                    : torus_field(middle, random_point(random, -1, 1),
                                  random_real(random, 0.35, 0.42), random_real(random, 0.12, 0.2));
            scene.objects.push_back({.field = sampled_in(space, n, field),
                                     .iso_world = random_real(random, -0.03, 0.03),
                                     .filter = random_int(random, 0, 3) == 0
                                                   ? Filter::CatmullRom
                                                   : Filter::Interpolating});
        }
        scene.tree = random_tree(random, object_count);
        return scene;
    }

    /// Judges the last picture's hits by a march in double; returns how many there are.
    ///
    /// greatest  sample
    /// slope     greatest, a voxel's edge
    int judge(const Scene& scene, const Image& hits, double greatest = 2,
              double slope = 1.1 * 1.3 * edge / (n - 1)) const {
        const Oracle oracle(scene);
        const double voxel = 0.9 * edge / (n - 1); // the shortest edge at least
        const double step = 0.1 * voxel;
        // A hit's value: 2^-19 of the samples (field_passes: u_value_error), and three times the
        // tolerance of 1e-5 of a voxel's edge, for places.
        const double value_error = 0x1p-19 * greatest + 3e-5 * slope;
        const double guarantee = 0.01 * 1.5 * voxel;
        std::atomic<int> count = 0;
        tbb::parallel_for(0, size * size, [&](int pixel) {
            const int x = pixel % size;
            const int y = pixel / size;
            Ray ray = camera_ray(camera, size, size, x + 0.5, y + 0.5);
            ray.direction_world.normalize();
            const auto at = [&](double t) -> Vec3d {
                return ray.origin_world + t * ray.direction_world;
            };
            const float* hit = hits.pixel(x, y);
            const bool is_hit = hit[3] != 0;
            if (is_hit) ++count;
            const double t_hit =
                is_hit ? (camera.eye_world + Vec3d(hit[0], hit[1], hit[2]) - ray.origin_world)
                             .dot(ray.direction_world)
                       : 1e9;
            if (is_hit) {
                const Vec3d p = at(t_hit);
                EXPECT_LT(std::abs(oracle.value(p)), value_error) << x << ' ' << y;
                // The owner's own function is zero there, too.
                const int owner = std::abs(int(hit[3])) - 1;
                EXPECT_LT(std::abs(oracle.values(p)[static_cast<std::size_t>(owner)]), value_error);
            }
            // Before it there is no stretch on the other side that is longer than the guarantee.
            const double nearest = std::max(0.0, ray.origin_world.norm() - 1.3);
            const double farthest = std::min(t_hit, ray.origin_world.norm() + 1.3);
            const bool starts_inside = oracle.value(at(0)) < 0;
            double stretch = 0;
            for (double t = nearest; t < farthest && stretch <= guarantee; t += step) {
                const double value = oracle.value(at(t));
                const bool is_other = starts_inside ? value > value_error : value < -value_error;
                if (!is_other) continue;
                // Its length to the next change, by finer steps.
                for (stretch = 0; stretch <= guarantee && t + stretch < farthest;
                     stretch += 0.1 * guarantee) {
                    const double on = oracle.value(at(t + stretch));
                    if (!(starts_inside ? on > value_error : on < -value_error)) break;
                }
            }
            EXPECT_LE(stretch, guarantee) << x << ' ' << y;
        });
        return count;
    }
};

TEST_F(RandomCsg, TreesAreThoseOfTheExactSplinesAlongEachRay) {
    Random random(7);
    size = 32;
    int hits_in_all = 0;
    for (int run = 0; run < 6; ++run) {
        const Scene scene = random_scene(random, random_int(random, 2, 4));
        camera = {.eye_world = 4 * random_point(random, -1, 1).normalized(),
                  .target_world = random_point(random, -0.2, 0.2),
                  .projection = run % 3 == 0 ? Projection::Orthographic : Projection::Perspective,
                  .height_world = 2.2};
        const Image hits = draw(scene, FrameImage::Hit);
        hits_in_all += judge(scene, hits);
    }
    EXPECT_GT(hits_in_all, 800);
}

TEST_F(RandomCsg, IsSeenFromWithinItsObjectsToo) {
    Random random(11);
    size = 32;
    int hits_in_all = 0;
    for (int run = 0; run < 4; ++run) {
        const Scene scene = random_scene(random, 3);
        camera = {.eye_world = random_point(random, -0.4, 0.4),
                  .target_world = random_point(random, -1, 1),
                  .fov_y_degrees = 80};
        const Image hits = draw(scene, FrameImage::Hit);
        hits_in_all += judge(scene, hits);
    }
    EXPECT_GT(hits_in_all, 800);
}

TEST_F(RandomCsg, PassesTheManyRootsOfNoise) {
    Random random(5);
    const GridSpace space = cube_around(Vec3d::Zero(), edge, n);
    const DenseField noise = random_dense(random, {Index3::Zero(), Index3::Constant(n)});
    const auto placed = std::make_shared<DenseField>(
        space, noise.extent(), std::vector(noise.values().begin(), noise.values().end()));
    const FieldObject ball{.field = sampled_in(space, n, sphere_field(Vec3d::Zero(), 0.4))};
    // Of control samples in [-3, 3] values are below 3, and their slopes below 3 sqrt 3 2 a voxel.
    for (const CsgOperation operation : {Intersection, Difference}) {
        for (const bool is_from_within : {false, true}) {
            // Ball minus noise, or what of the noise lies in the ball: all of it is in the ball.
            const Scene scene{.objects = {ball, {.field = placed}}, .tree = pair(operation)};
            camera = {.eye_world = is_from_within ? Vec3d(0.1, 0, 0.05) : Vec3d(2, 1, 3),
                      .target_world = Vec3d(0.01, 0.03, 0.02),
                      .fov_y_degrees = is_from_within ? 90.0 : 20.0};
            size = 48;
            EXPECT_GT(judge(scene, draw(scene, FrameImage::Hit), 3, 10.4), 500);
            EXPECT_FALSE(report.notes.empty());
        }
    }
}

TEST_F(RandomCsg, GradientsAndCurvaturesAreTheOwnersAndReversedWhereItIsTakenAway) {
    Random random(3);
    size = 64;
    int reversed = 0;
    int creases = 0;
    for (int run = 0; run < 6; ++run) {
        Scene scene = random_scene(random, 3);
        for (FieldObject& object : scene.objects) object.filter = Filter::Interpolating;
        scene.tree = {{Object, 0}, {Object, 1}, {Difference}, {Object, 2}, {Difference}};
        const Oracle oracle(scene);
        renderer.load(scene);
        renderer.draw(camera, size, size,
                      {FrameImage::Hit, FrameImage::Gradient, FrameImage::Curvature});
        const Image hits = renderer.read(FrameImage::Hit);
        const Image gradients = renderer.read(FrameImage::Gradient);
        const Image curvatures = renderer.read(FrameImage::Curvature);
        for_each_hit(hits, [&](const Vec3d& p, int owner, std::size_t i) {
            const double sign = owner < 0 ? -1 : 1;
            reversed += owner < 0 ? 1 : 0;
            creases +=
                i + 4 < hits.rgba.size() && hits.rgba[i + 7] != 0 && int(hits.rgba[i + 7]) != owner
                    ? 1
                    : 0;
            const Vec3d exact = sign * oracle.gradient(std::abs(owner) - 1, p);
            const Vec3d found(gradients.rgba[i], gradients.rgba[i + 1], gradients.rgba[i + 2]);
            // Samples of at most 2, sums of |weights| of 2 a voxel, 32 roundings: 2^-18 a voxel of
            // 0.9 * 1.7/27; places to 1e-5 voxel, times second derivatives of at most 1/0.1.
            EXPECT_LT((found - exact).norm(), 0x1p-17 / 0.05) << owner;
            const FieldObject& object =
                scene.objects[static_cast<std::size_t>(std::abs(owner) - 1)];
            const auto control = control_samples(object.field, object.filter);
            const GridSpace& space = object.field->space();
            const Jet jet = kernel_jet(*control, space.to_index(p), Kernel::BSpline);
            const Curvatures c = principal_curvatures(sign * space.gradient_to_world(jet.gradient),
                                                      sign * space.hessian_to_world(jet.hessian));
            EXPECT_NE(curvatures.rgba[i + 3], 2);
            // The same with |weights| of 4 a voxel^2, and third derivatives of at most 2/0.1^2.
            EXPECT_NEAR(curvatures.rgba[i], c.k1, 0x1p-16 / 0.05 / 0.05);
            EXPECT_NEAR(curvatures.rgba[i + 1], c.k2, 0x1p-16 / 0.05 / 0.05);
        });
    }
    EXPECT_GT(reversed, 300);
    EXPECT_GT(creases, 50);
}

TEST_F(Csg, IsFiniteWhereAGradientVanishes) {
    // A double cone of f = x^2 + y^2 - z^2, less a ball that touches its apex, and its apex alone.
    const GridSpace space = cube_around(Vec3d::Zero(), 2, 33); // the apex is a sample
    const auto cone = sampled_in(
        space, 33, {"cone", [](const Vec3d& p) {
                        return Jet{p.x() * p.x() + p.y() * p.y() - p.z() * p.z(), {}, {}};
                    }});
    const FieldObject touching{.field = sampled_in(space, 33, sphere_field({0, 0, 0.5}, 0.5))};
    for (const CsgOperation operation : {Union, Intersection, Difference}) {
        for (const Vec3d& direction : {Vec3d(1, 0, 0), Vec3d(0, 0, 1), Vec3d(1, 1, 1)}) {
            look_from(direction.normalized(), 1.5);
            size = 65; // a ray meets the apex
            renderer.load({.objects = {{.field = cone}, touching}, .tree = pair(operation)});
            const ImageSet wanted{FrameImage::Hit, FrameImage::Gradient, FrameImage::Curvature,
                                  FrameImage::Beauty};
            renderer.draw(camera, size, size, wanted);
            for (const FrameImage image :
                 {FrameImage::Hit, FrameImage::Gradient, FrameImage::Curvature, FrameImage::Beauty})
                for (const float value : renderer.read(image).rgba)
                    ASSERT_TRUE(std::isfinite(value)) << name_of(image);
        }
    }
}

TEST_F(Csg, FarFromTheOriginAndTheEyeIsAsExact) {
    const Vec3d far(1e4, -3e4, 2e4);
    for (FieldObject* object : {&spheres.objects[0], &spheres.objects[1]}) {
        const auto& dense = dynamic_cast<const DenseField&>(*object->field);
        GridSpace space = dense.space();
        space.world_from_index.translation() += far;
        object->field = std::make_shared<DenseField>(
            space, dense.extent(), std::vector(dense.values().begin(), dense.values().end()));
    }
    camera = {.eye_world = far + Vec3d(300, 200, 400), .target_world = far, .fov_y_degrees = 0.3};
    // Hits are eye-relative floats: 540 of them have steps of 6e-5.
    const Image hits = draw_pair(Union);
    const int count = for_each_hit(hits, [&](const Vec3d& p_world, int owner, std::size_t) {
        const Vec3d p = p_world - far;
        EXPECT_NEAR((p - Vec3d(owner == 1 ? -0.45 : 0.45, 0, 0)).norm(), radius, 1e-4);
        if (std::abs(p.x()) > 1e-4) {
            EXPECT_EQ(owner, p.x() < 0 ? 1 : 2);
        }
    });
    EXPECT_GT(count, 1000);
}

TEST_F(Csg, ObjectsThatStayTheSameAreNotLoadedAgain) {
    spheres.look.model = ShadingModel::Flat;
    renderer.load(spheres);
    const BrickPool* const first = &renderer.pool(0);
    // The second changes its iso value, the first only its colour and place.
    std::swap(spheres.objects[0], spheres.objects[1]);
    spheres.objects[0].iso_world = 0.05;
    spheres.objects[1].colour = {0, 1, 0};
    renderer.load(spheres);
    EXPECT_EQ(&renderer.pool(1), first);
    Renderer fresh(*context, shader_folder);
    fresh.load(spheres);
    for (Renderer* drawer : {&renderer, &fresh})
        drawer->draw(camera, size, size, {FrameImage::Hit, FrameImage::Beauty});
    EXPECT_EQ(renderer.read(FrameImage::Hit).rgba, fresh.read(FrameImage::Hit).rgba);
    EXPECT_EQ(renderer.read(FrameImage::Beauty).rgba, fresh.read(FrameImage::Beauty).rgba);
}

TEST_F(Csg, ObjectsHaveTheirColoursAndThoseOfTheirCuts) {
    spheres.look.model = ShadingModel::Flat;
    spheres.objects[0].colour = {1, 0, 0};
    spheres.objects[1].colour = {0, 1, 0};
    for (const std::optional<Vec3d>& cut :
         {std::optional<Vec3d>(), std::optional<Vec3d>({0, 0, 1})}) {
        spheres.objects[1].cut_colour = cut;
        camera.eye_world = {4, 1, 2};
        const Image hits = draw_pair(Difference);
        const Image picture = draw_pair(Difference, FrameImage::Beauty);
        std::array<int, 2> counts{};
        for_each_hit(hits, [&](const Vec3d&, int owner, std::size_t i) {
            const Vec3d expected = owner == 1 ? Vec3d(1, 0, 0) : cut.value_or(Vec3d(0, 1, 0));
            for (int c = 0; c < 3; ++c)
                EXPECT_EQ(picture.rgba[i + static_cast<std::size_t>(c)], expected[c]);
            ++counts[owner == 1 ? 0 : 1];
        });
        EXPECT_GT(counts[0], 200);
        EXPECT_GT(counts[1], 200);
    }
    spheres.objects[1].colour.reset(); // the material's
    const Image picture = draw_pair(Union, FrameImage::Beauty);
    const Image hits = draw_pair(Union);
    for_each_hit(hits, [&](const Vec3d&, int owner, std::size_t i) {
        // Halves: 2^-11 of values below one.
        if (owner != 2) return;
        EXPECT_NEAR(picture.rgba[i], spheres.look.material.colour.x(), 0x1p-11);
    });
}

TEST_F(Csg, TakesOnlyTheWorkThatItsTreeNeeds) {
    const auto note = [&] { return report.notes.empty() ? "" : report.notes.front(); };
    draw_pair(Union);
    EXPECT_EQ(note(), "composition: 2 objects, 1 rounds, 2 searches");
    // One for each object's storage, which differ in nothing but strides, and the composition.
    EXPECT_EQ(report.programs_compiled, 2);
    EXPECT_EQ(report.image_bytes, std::int64_t{size} * size * 16);
    EXPECT_EQ(report.scratch_bytes, std::int64_t{size} * size * (2 * 16 + 4));
    EXPECT_FALSE(pass("gradient").ran);
    EXPECT_FALSE(pass("shading").ran);
    // Apart, the intersection is known to be empty after one search of each.
    spheres.objects[1] = ball(5, 40);
    draw_pair(Intersection);
    EXPECT_EQ(note(), "composition: 2 objects, 1 rounds, 2 searches");
}

TEST_F(Csg, DoesNotExistInAPlainScene) {
    const Scene plain{.field = spheres.objects[0].field};
    draw(plain);
    EXPECT_EQ(report.programs_compiled, 2); // raycast with gradients, shading
    EXPECT_EQ(report.scratch_bytes, 0);
    EXPECT_TRUE(report.notes.empty());
    // One object in the list is a plain scene, too.
    const Image picture = renderer.read(FrameImage::Beauty);
    EXPECT_EQ(draw({.objects = {{.field = plain.field}}}).rgba, picture.rgba);
    EXPECT_EQ(report.programs_compiled, 2);
    EXPECT_EQ(report.scratch_bytes, 0);
}

TEST_F(Csg, MovesTheIsosurfaceOfAnObject) {
    spheres.tree = pair(Difference);
    renderer.load(spheres);
    renderer.set_iso(0.1, 1);
    renderer.draw(camera, size, size, {FrameImage::Hit});
    const Image moved = renderer.read(FrameImage::Hit);
    spheres.objects[1].iso_world = 0.1;
    EXPECT_EQ(draw(spheres, FrameImage::Hit).rgba, moved.rgba);
}

TEST_F(Csg, BoxIsThatOfTheTree) {
    const auto box = [&](CsgOperation operation) {
        spheres.tree = pair(operation);
        renderer.load(spheres);
        Eigen::AlignedBox3d around;
        for (const Vec3d& corner : renderer.surface_box_world()) around.extend(corner);
        return around;
    };
    const double voxel = 2.0 / 39; // a box is that of cells
    EXPECT_NEAR(box(Union).sizes().x(), 2 * radius + apart, 2 * voxel);
    EXPECT_NEAR(box(Intersection).sizes().x(), 2 * radius - apart, 2 * voxel);
    EXPECT_NEAR(box(Difference).sizes().x(), 2 * radius, 2 * voxel);
    spheres.objects[1] = ball(5, 40);
    box(Intersection);
    EXPECT_FALSE(renderer.has_surface());
}

TEST_F(Csg, RefusesWhatItCannotDo) {
    Scene scene = spheres;
    scene.quality.rate = 1;
    EXPECT_THROW(renderer.load(scene), InputError);
    scene = spheres;
    scene.quality.traversal = Traversal::Walk;
    EXPECT_THROW(renderer.load(scene), InputError);
    scene = spheres;
    scene.storage.budget_bytes = 100'000;
    EXPECT_THROW(renderer.load(scene), ResourceError);
    scene = spheres;
    scene.field = spheres.objects[0].field;
    EXPECT_THROW(renderer.load(scene), InputError);
    scene = spheres;
    scene.objects.resize(max_object_count + 1, scene.objects[0]);
    EXPECT_THROW(renderer.load(scene), InputError);
    scene = spheres;
    scene.objects[1].field.reset();
    EXPECT_THROW(renderer.load(scene), InputError);
    scene = spheres;
    scene.tree = {{Object, 0}};
    EXPECT_THROW(renderer.load(scene), InputError);
}

} // namespace
} // namespace isocast::test
