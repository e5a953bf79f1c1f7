// Quadrics in tetrahedra as they are drawn, against a double ray caster that knows their planes and
// equations; where nothing else is said, not one pixel differs.
// SPDX-License-Identifier: MPL-2.0
#include "../quadrics/random_primitives.h"
#include "../splats/splat_judge.h"
#include "../volume/temporary_folder.h"
#include "quadrics/quadratic_spline.h"
#include "quadrics/tetrahedral_field.h"
#include "renderer_test_base.h"
#include "volume/analytic_fields.h"
#include "volume/dense_field.h"
#include "volume/errors.h"

#include <gmock/gmock.h>

#include <fstream>

namespace isocast::test {
namespace {

using Corners = std::array<Vec3d, 4>;

struct Tetrahedra : RendererTest {
    Camera camera{.eye_world = {0.3, 0.4, 6}, .target_world = Vec3d::Zero()};
    Random random{3};

    std::array<float, 10> coefficients() {
        std::array<float, 10> out;
        for (float& c : out) c = static_cast<float>(random.uniform(-1, 1));
        return out;
    }
    TetrahedralMesh one(const Corners& corners, const std::array<float, 10>& c) {
        TetrahedralMesh mesh{.vertices_world = {corners.begin(), corners.end()},
                             .tetrahedra = {},
                             .coefficients = {}};
        append(mesh, {0, 1, 2, 3}, c);
        return mesh;
    }
    TetrahedralMesh some() {
        return one({random.in_cube(1), random.in_cube(1), random.in_cube(1), random.in_cube(1)},
                   coefficients());
    }
    /// error  of positions, by their distance from the eye; roots are as ill-conditioned as rays
    ///        graze the surface
    Judgement expect_exact(const Primitives& primitives, double error = 1e-5, int width = 320,
                           int height = 240) {
        const Judgement judgement = judge(renderer, primitives, camera, width, height);
        // A pixel in 1e5 lies within floats' roundings of an edge or a silhouette.
        EXPECT_LE(judgement.wrong, 1) << "at " << testing::PrintToString(judgement.pixels);
        EXPECT_LT(judgement.worst_error, error);
        return judgement;
    }
};

TEST_F(Tetrahedra, AreWhatTheRaysMeet) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        for (int run = 0; run < 4; ++run) {
            Primitives many;
            for (int i = 0; i < 20; ++i) many.tetrahedra.push_back(some());
            EXPECT_GT(expect_exact(many).seen, 2000);
        }
    }
}

TEST_F(Tetrahedra, FromQuadricsToPlanesAreWhatTheRaysMeet) {
    int seen = 0;
    for (const double bend : {1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 0.0})
        for (int run = 0; run < 4; ++run) {
            SCOPED_TRACE(bend);
            std::array<float, 10> c = coefficients();
            c[0] = -1;
            c[1] = 1;
            for (std::size_t e = 0; e < 6; ++e)
                c[4 + e] = (c[std::size_t(tetrahedron_edges[e][0])] +
                            c[std::size_t(tetrahedron_edges[e][1])]) /
                               2 +
                           static_cast<float>(bend) * c[4 + e];
            seen += expect_exact({.tetrahedra = {one({random.in_cube(1.5), random.in_cube(1.5),
                                                      random.in_cube(1.5), random.in_cube(1.5)},
                                                     c)}})
                        .seen;
        }
    EXPECT_GT(seen, 10000);
}

// 1e-6 high: the surface in it is as thin as a line from the side, and a triangle or a
// quadrilateral from above.
TEST_F(Tetrahedra, ThatAreSliversAreExact) {
    int seen = 0;
    for (int run = 0; run < 40; ++run) {
        const Vec3d up = random.unit();
        const Vec3d a = up.cross(random.unit()).normalized();
        const Vec3d b = up.cross(a);
        std::array<float, 10> c = coefficients();
        // Across the height: below and above the corners' plane the function differs in sign.
        for (std::size_t k = 0; k < 3; ++k) c[k] = -1 - std::abs(c[k]);
        c[3] = 3;
        seen +=
            expect_exact(
                {.tetrahedra = {one(
                     {a, Vec3d(b - 0.5 * a), Vec3d(-b - 0.5 * a), Vec3d(1e-6 * up + 0.1 * a)}, c)}})
                .seen;
    }
    EXPECT_GT(seen, 40000);
}

// 1,000 pairs with a common face: what rays meet in one or the other shows no hole.
TEST_F(Tetrahedra, ThatShareAFaceLeaveNoCrack) {
    constexpr int size = 48;
    int holes = 0;
    int between = 0;
    for (int run = 0; run < 1000; ++run) {
        TetrahedralMesh pair;
        for (int k = 0; k < 5; ++k) pair.vertices_world.push_back(random.in_cube(1));
        const std::array<float, 10> c = coefficients();
        std::array<float, 10> other = coefficients();
        for (const std::size_t shared : {0, 1, 2, 4, 5, 7}) other[shared] = c[shared];
        // The second has its corners in another order.
        const std::array<int, 4> turned{4, 0, 2, 1};
        const std::array<float, 10> in_order{other[3], other[0], other[2], other[1], other[6],
                                             other[9], other[8], other[5], other[4], other[7]};
        append(pair, {0, 1, 2, 3}, c);
        append(pair, turned, in_order);
        // Drawn towards the face's plane, too.
        camera.eye_world = run % 4 == 0
                               ? Vec3d(pair.vertices_world[0] +
                                       5 * (pair.vertices_world[1] - pair.vertices_world[0]))
                               : Vec3d(6 * random.unit());
        camera.projection = run % 2 == 0 ? Projection::Perspective : Projection::Orthographic;
        const Primitives scene{.tetrahedra = {pair}};
        if (scene.count() == 0) continue;
        const Holes seen = holes_in(renderer, scene, scene, camera, size);
        between += seen.met;
        holes += seen.holes;
    }
    EXPECT_GT(between, 100000);
    EXPECT_EQ(holes, 0);
}

TEST_F(Tetrahedra, FarAwayFarFromTheOriginAndAroundTheEye) {
    for (const double distance : {1e2, 1e3, 1e4}) {
        camera.eye_world = distance * Vec3d(0.3, 0.5, 1).normalized();
        camera.fov_y_degrees = 2 * std::atan(1.2 / distance) * 180 / std::acos(-1.0);
        for (int run = 0; run < 5; ++run) {
            const Judgement judgement = judge(renderer, {.tetrahedra = {some()}}, camera, 121, 121);
            EXPECT_EQ(judgement.wrong, 0) << testing::PrintToString(judgement.pixels);
        }
    }
    const Vec3d far = 1e6 * Vec3d(1, -2, 3);
    camera = {.eye_world = far + Vec3d(0.3, 0.4, 6), .target_world = far};
    for (int run = 0; run < 5; ++run) {
        TetrahedralMesh mesh = some();
        for (Vec3d& vertex : mesh.vertices_world) vertex += far;
        expect_exact({.tetrahedra = {mesh}});
    }
    int seen = 0;
    for (int run = 0; run < 20; ++run) {
        TetrahedralMesh around = one({camera.eye_world + 3 * Vec3d(1, 1, 1) + random.in_cube(1),
                                      camera.eye_world + 3 * Vec3d(-1, -1, 1) + random.in_cube(1),
                                      camera.eye_world + 3 * Vec3d(-1, 1, -1) + random.in_cube(1),
                                      camera.eye_world + 3 * Vec3d(1, -1, -1) + random.in_cube(1)},
                                     coefficients());
        seen += expect_exact({.tetrahedra = {around}}, 1e-4).seen;
    }
    EXPECT_GT(seen, 100000);
}

constexpr double ball_radius = 0.8;

/// A ball, as one function in the tetrahedra of a cube's spline, which gives quadratic functions
/// back exactly.
TetrahedralMesh ball() {
    std::vector<float> values;
    const int n = 13;
    for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x)
                values.push_back(
                    static_cast<float>((Vec3d(x, y, z) / 4 - Vec3d::Constant(1.5)).squaredNorm() -
                                       ball_radius * ball_radius));
    GridSpace space;
    space.world_from_index = Eigen::Translation3d(-1.5, -1.5, -1.5) * Eigen::Scaling(0.25);
    return quadratic_spline(DenseField(space, {Index3::Zero(), Index3::Constant(n)}, values), 0);
}

// As a sphere does.
TEST_F(Tetrahedra, CastShadowsAndHideTheSky) {
    const PatchMesh floor{.vertices_world = {{-2, -1, 2}, {2, -1, 2}, {2, -1, -2}, {-2, -1, -2}},
                          .quads = {{0, 1, 2, 3}}};
    camera.eye_world = {1, 3, 6};
    const Vec3d light = Vec3d(0.4, 1, 0.3).normalized();
    constexpr int size = 160;
    const auto of_spline = shadows_and_sky(renderer, {.patches = {floor}, .tetrahedra = {ball()}},
                                           light, camera, size);
    const auto of_sphere =
        shadows_and_sky(renderer, {.spheres = {{.radius_world = ball_radius}}, .patches = {floor}},
                        light, camera, size);
    int dark = 0, hidden = 0, other_shadow = 0, other_sky = 0;
    for (std::size_t i = 0; i < of_sphere[2].rgba.size(); i += 4) {
        // On the floor alone: a sphere's own rays start differently.
        if (of_sphere[2].rgba[i + 3] == 0 || of_spline[2].rgba[i + 3] == 0) continue;
        if (camera.eye_world.y() + double(of_sphere[2].rgba[i + 1]) > -0.99) continue;
        dark += of_sphere[0].rgba[i] == 0;
        hidden += of_sphere[1].rgba[i] < 1;
        // A texel of the light's picture is less than 6 / size.
        const Vec3d p = point_at(of_spline[2], i, camera);
        const double inside = ball_radius - p.cross(light).norm();
        if (std::abs(inside) > 2 * 6.0 / size)
            other_shadow += (of_spline[0].rgba[i] == 0) != (inside > 0);
        other_sky += of_sphere[1].rgba[i] != of_spline[1].rgba[i];
    }
    EXPECT_GT(dark, 500);
    EXPECT_GT(hidden, 500);
    EXPECT_EQ(other_shadow, 0);
    EXPECT_LT(other_sky, 10); // where a ray grazes the ball
}

TEST_F(Tetrahedra, HaveTheNormalsAndCurvaturesOfTheirSurface) {
    constexpr double radius = ball_radius;
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera = {.eye_world = {1, -2, 5},
                  .target_world = Vec3d::Zero(),
                  .projection = projection,
                  .height_world = 2};
        renderer.load(
            {.primitives = std::make_shared<Primitives>(Primitives{.tetrahedra = {ball()}})});
        renderer.draw(camera, 100, 100,
                      {FrameImage::Hit, FrameImage::Gradient, FrameImage::Curvature});
        const Image hits = renderer.read(FrameImage::Hit);
        const Image normals = renderer.read(FrameImage::Gradient);
        const Image curvatures = renderer.read(FrameImage::Curvature);
        const auto sphere =
            cast_primitives({.spheres = {{.radius_world = radius}}}, camera, 100, 100);
        int seen = 0;
        for (std::size_t i = 0; i < sphere.size(); ++i) {
            const float* hit = &hits.rgba[4 * i];
            const bool is_hit = hit[3] != 0;
            // The samples' own roundings move the silhouette by 1e-7.
            EXPECT_EQ(is_hit, sphere[i].number >= 0) << i;
            if (!is_hit || sphere[i].number < 0) continue;
            ++seen;
            const Vec3d p =
                camera.eye_world + Eigen::Map<const Eigen::Vector3f>(hit).cast<double>();
            // 1e-5: Hessians are second differences of floats at 1/4, inside boxes of 1e-1.
            EXPECT_NEAR(p.norm(), radius, 3e-6);
            EXPECT_LT((Eigen::Map<const Eigen::Vector3f>(&normals.rgba[4 * i]).cast<double>() -
                       p.normalized())
                          .norm(),
                      1e-5);
            EXPECT_NEAR(curvatures.rgba[4 * i], 1 / radius, 1e-4);
            EXPECT_NEAR(curvatures.rgba[4 * i + 1], 1 / radius, 1e-4);
        }
        EXPECT_GT(seen, 1000);
    }
}

// Faces and edges along rows and columns of pixels, and vertices in their middles.
TEST_F(Tetrahedra, OfAClosedSurfaceLeaveNoHole) {
    const TetrahedralMesh whole = quadratic_spline(*sampled(builtin_field("sphere"), 17), 0);
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic})
        for (const Vec3d& direction : {Vec3d(0, 0, 1), Vec3d(0, 0, -1), Vec3d(1, 0, 0),
                                       Vec3d(1, 1, 0), random.unit(), random.unit()})
            for (const int size : {100, 101, 224}) {
                camera = {.eye_world = 5 * direction,
                          .target_world = Vec3d::Zero(),
                          .projection = projection,
                          .height_world = 2.625};
                renderer.load({.primitives = std::make_shared<Primitives>(
                                   Primitives{.tetrahedra = {whole}})});
                renderer.draw(camera, size, size, {FrameImage::Hit});
                const Image hits = renderer.read(FrameImage::Hit);
                const auto inner =
                    cast_primitives({.spheres = {{.radius_world = 0.97}}}, camera, size, size);
                int holes = 0;
                for (std::size_t i = 0; i < inner.size(); ++i)
                    if (inner[i].number >= 0) {
                        const Vec3d p = point_at(hits, 4 * i, camera);
                        // Through a hole its far side is seen, or nothing.
                        holes += hits.rgba[4 * i + 3] == 0 || p.dot(direction) < 0;
                    }
                EXPECT_EQ(holes, 0);
            }
}

int drawn_of(const TetrahedralMesh& mesh, const SplatView& view) {
    return splats_of(Primitives{.tetrahedra = {mesh}}, view).count(SplatKind::Tetrahedron);
}

// Bit by bit what all of them show, with about half of them.
TEST_F(Tetrahedra, ThatFaceAwayAreNotDrawn) {
    for (const char* name : {"sphere", "torus"}) {
        TetrahedralMesh mesh = quadratic_spline(*sampled(builtin_field(name), 40), 0);
        ASSERT_TRUE(mesh.is_closed);
        for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
            for (int run = 0; run < 5; ++run) {
                camera = {.eye_world = random.uniform(3, 20) * random.unit(),
                          .target_world = Vec3d::Zero(),
                          .projection = projection,
                          .height_world = 3};
                std::vector<Image> images;
                for (const bool is_closed : {true, false}) {
                    mesh.is_closed = is_closed;
                    renderer.load({.primitives = std::make_shared<Primitives>(
                                       Primitives{.tetrahedra = {mesh}})});
                    renderer.draw(camera, 160, 120, {FrameImage::Hit, FrameImage::Curvature});
                    images.push_back(renderer.read(FrameImage::Hit));
                    images.push_back(renderer.read(FrameImage::Curvature));
                }
                EXPECT_EQ(images[0].rgba, images[2].rgba);
                EXPECT_EQ(images[1].rgba, images[3].rgba);
            }
        }
        mesh.is_closed = true;
        SplatView view{.space = {.eye_world = {0, 0, 6}},
                       .pixels_per_unit = 300,
                       .middle_pixels = {100, 100},
                       .width = 200,
                       .height = 200};
        TetrahedralMesh open = mesh;
        open.is_closed = false;
        const int all = drawn_of(open, view);
        // Half of the surface, but for what holds a piece of its contour.
        EXPECT_LT(drawn_of(mesh, view), 0.65 * all);
        EXPECT_GT(drawn_of(mesh, view), 0.35 * all);
        // Where insides show, all are drawn.
        view.planes = {{{0, 0, 1}, 0.3}};
        EXPECT_EQ(drawn_of(mesh, view), drawn_of(open, view));
        view.planes.clear();
        view.space.eye_world = {0.5, 0.5, 0};
        EXPECT_EQ(drawn_of(mesh, view), drawn_of(open, view));
    }
}

TEST(QuadraticSpline, IsOpenWhereTheBoxCutsIt) {
    EXPECT_TRUE(quadratic_spline(*sampled(builtin_field("sphere"), 24), 0).is_closed);
    EXPECT_FALSE(quadratic_spline(*sampled(builtin_field("gyroid"), 24), 0).is_closed);
    // Inside out: the box is full, but for a ball.
    std::vector<float> values(1000, -1);
    values[555] = 1;
    const DenseField field(GridSpace{}, {Index3::Zero(), Index3::Constant(10)}, values);
    EXPECT_FALSE(quadratic_spline(field, 0).is_closed);
}

TEST(QuadraticSpline, ConvergesAtThirdOrder) {
    // Hits of rays through the torus against those of the field itself.
    const AnalyticField torus = builtin_field("torus");
    std::vector<double> errors;
    for (const int n : {17, 33, 65}) {
        const auto field = sampled(builtin_field("torus"), n);
        const TetrahedralMesh mesh = quadratic_spline(*field, 0);
        double worst = 0;
        Random random(1);
        for (std::size_t i = 0; i < mesh.tetrahedra.size(); i += mesh.tetrahedra.size() / 500) {
            const Tetrahedron t = tetrahedron_of(mesh, i);
            const Vec3d middle = 0.25 * (t.corners_world[0] + t.corners_world[1] +
                                         t.corners_world[2] + t.corners_world[3]);
            const Vec3d way = random.unit();
            const auto hit = intersect(t, middle - way, way);
            if (hit)
                worst = std::max(worst, std::abs(torus.jet(middle + (hit->t - 1) * way).value));
        }
        errors.push_back(worst);
    }
    EXPECT_GT(errors[0] / errors[1], 5) << errors[0]; // 8 in the limit
    EXPECT_GT(errors[1] / errors[2], 6) << errors[1];
    EXPECT_LT(errors[2], 1e-3);
}

TEST(QuadraticSpline, HasOneValueInACommonFace) {
    const TetrahedralMesh mesh = quadratic_spline(*sampled(builtin_field("gyroid"), 24), 0);
    std::map<std::array<int, 3>, std::array<float, 6>> faces;
    int shared = 0;
    for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
        const Eigen::Matrix4d c = tetrahedron_of(mesh, i).coefficients;
        for (int without = 0; without < 4; ++without) {
            std::array<int, 3> face{};
            std::array<int, 3> at{};
            for (int k = 0, next = 0; k < 4; ++k)
                if (k != without) {
                    face[std::size_t(next)] = mesh.tetrahedra[i][std::size_t(k)];
                    at[std::size_t(next++)] = k;
                }
            const auto value = [&](int a, int b) {
                return static_cast<float>(c(at[std::size_t(a)], at[std::size_t(b)]));
            };
            const std::array<float, 6> values{value(0, 0), value(1, 1), value(2, 2),
                                              value(0, 1), value(0, 2), value(1, 2)};
            const auto [place, is_new] = faces.try_emplace(face, values);
            shared += !is_new;
            EXPECT_EQ(place->second, values); // the same floats
        }
    }
    EXPECT_GT(shared, 10000);
}

std::filesystem::path written(const TemporaryFolder& folder, const std::string& text) {
    const std::filesystem::path path = folder / "a.vtk";
    std::ofstream(path) << text;
    return path;
}

const std::string header = "# vtk DataFile Version 3.0\nx^2 + y^2 + z^2\nASCII\n"
                           "DATASET UNSTRUCTURED_GRID\n";
const std::string quadratic_points =
    "POINTS 10 double\n0 0 0  2 0 0  0 2 0  0 0 2\n1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  0 1 1\n";

TEST(TetrahedralFile, IsReadAsItsFunction) {
    const TemporaryFolder folder;
    const TetrahedralField field = read_tetrahedra(
        written(folder, header + quadratic_points +
                            "CELLS 1 11\n10 0 1 2 3 4 5 6 7 8 9\nCELL_TYPES 1\n24\nPOINT_DATA 10\n"
                            "SCALARS f double 1\nLOOKUP_TABLE default\n0 4 4 4 1 2 1 1 2 2\n"));
    const TetrahedralMesh mesh = isosurface(field, 1);
    ASSERT_EQ(mesh.tetrahedra.size(), 1);
    Random random(2);
    for (int run = 0; run < 50; ++run) {
        const Vec3d way = random.unit().cwiseAbs();
        const auto hit = intersect(tetrahedron_of(mesh, 0), Vec3d::Zero(), way);
        if (way.sum() > 2 * way.norm()) continue;
        ASSERT_TRUE(hit) << way.transpose();
        EXPECT_NEAR(hit->t, 1, 1e-7);
        EXPECT_LT((hit->normal - way).norm(), 1e-7);
    }
    EXPECT_TRUE(isosurface(field, 5).tetrahedra.empty());
}

TEST(TetrahedralFile, ThatIsWrongIsRefusedWithTheCause) {
    const TemporaryFolder folder;
    const std::string cells = "CELLS 1 11\n10 0 1 2 3 4 5 6 7 8 9\nCELL_TYPES 1\n24\n";
    const std::string values = "POINT_DATA 10\nSCALARS f double 1\nLOOKUP_TABLE default\n"
                               "0 4 4 4 1 2 1 1 2 2\n";
    const auto expect = [&](const std::string& text, const char* cause) {
        EXPECT_THAT([&] { read_tetrahedra(written(folder, text)); },
                    testing::ThrowsMessage<InputError>(testing::HasSubstr(cause)));
    };
    expect("nothing", "does not begin with");
    expect(header + quadratic_points + values, "no cells");
    expect(header + quadratic_points + cells, "0 values for 10 points");
    expect(header + "POINTS 2 float\n0 0 0 1 x 1\n", "y is not a number: 'x'");
    expect(header + "POINTS 2 float\n0 0 0 1", "truncated: y is missing");
    expect(header + quadratic_points + "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n12\n" + values,
           "cell 0 has the type 12");
    expect(header + quadratic_points + "CELLS 1 5\n4 0 1 2 10\nCELL_TYPES 1\n10\n" + values,
           "there is no point 10");
    std::string bent = quadratic_points;
    bent.replace(bent.find("1 1 0"), 5, "1.5 1.5 0");
    expect(header + bent + cells + values, "point 5 is not the middle of an edge");
    EXPECT_THROW(read_tetrahedra(folder / "none.vtk"), InputError);
}

} // namespace
} // namespace isocast::test
