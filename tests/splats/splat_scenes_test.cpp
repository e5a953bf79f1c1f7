// Primitives beside fields, and what effects make of them.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/sample_meshes.h"
#include "filtering/curvature.h"
#include "quadrics/quadric.h"
#include "renderer_test_base.h"
#include "some_primitives.h"
#include "splat_judge.h"
#include "volume/analytic_fields.h"

namespace isocast::test {
namespace {

constexpr double nowhere = std::numeric_limits<double>::infinity();

struct SplatScenes : RendererTest {
    Camera camera{.eye_world = {0.8, 1.1, 5}, .target_world = Vec3d::Zero()};
    int size = 160;
    Random random{3};

    Ray ray_of(std::size_t pixel) const {
        const auto width = static_cast<std::size_t>(size);
        return camera_ray(camera, size, size, double(pixel % width) + 0.5,
                          double(pixel / width) + 0.5);
    }
    const PassReport& pass(const FrameReport& report, std::string_view name) const {
        for (const PassReport& p : report.passes)
            if (p.name == name) return p;
        throw std::logic_error("no such pass");
    }
};

/// Where a ray meets a ball.
double ball_t(const Ray& ray, const Vec3d& centre, double radius) {
    const auto hit = intersect(Sphere{.centre_world = centre, .radius_world = radius},
                               ray.origin_world, ray.direction_world);
    return hit ? hit->t : nowhere;
}

TEST_F(SplatScenes, FieldsAndPrimitivesIntersectAlongTheRightCurves) {
    const std::shared_ptr<const FieldSource> field =
        sampled(sphere_field(Vec3d(0.1, 0, 0), 0.6), 64);
    Primitives primitives;
    primitives.spheres = {{.centre_world = {0.6, 0.1, 0.2}, .radius_world = 0.4},
                          {.centre_world = {-0.4, 0.3, 0.4}, .radius_world = 0.3}};
    primitives.cylinders = {
        {.a_world = {0, -1, 0}, .b_world = {0.2, 1, 0.1}, .radius_world = 0.15}};
    number_by_colour(primitives);
    // A 64^3 sphere of the interpolating filter is within f'''' h^4 / 192 a line of its place.
    const double h = 2.0 / 63;
    const double field_error = 3 * 15 / std::pow(0.6, 3) / 192 * std::pow(h, 4);
    for (const bool is_composed : {false, true}) {
        Scene scene{.primitives = std::make_shared<Primitives>(primitives)};
        scene.objects.push_back({.field = field});
        if (is_composed) // its lower half alone
            scene.objects.push_back({.field = sampled(sphere_field(Vec3d(0.1, 0.7, 0), 0.5), 64)});
        if (is_composed)
            scene.tree = {
                {CsgOperation::Object, 0}, {CsgOperation::Object, 1}, {CsgOperation::Difference}};
        const double primitive_owner = is_composed ? 3 : 2;
        renderer.load(scene);
        renderer.draw(camera, size, size,
                      {FrameImage::Hit, FrameImage::SplatColour, FrameImage::Gradient});
        const Image hits = renderer.read(FrameImage::Hit);
        const Image colours = renderer.read(FrameImage::SplatColour);
        const Image gradients = renderer.read(FrameImage::Gradient);
        const std::vector<SeenPrimitive> seen = cast_primitives(primitives, camera, size, size);
        int field_pixels = 0;
        int primitive_pixels = 0;
        for (std::size_t i = 0; i < seen.size(); ++i) {
            const double owner = hits.rgba[4 * i + 3];
            if (owner == primitive_owner) {
                ++primitive_pixels;
                EXPECT_EQ(number_of_colour(&colours.rgba[4 * i]), seen[i].number);
                const Vec3d normal(gradients.rgba[4 * i], gradients.rgba[4 * i + 1],
                                   gradients.rgba[4 * i + 2]);
                EXPECT_LT((normal - seen[i].normal).norm(), 1e-3);
            } else {
                EXPECT_EQ(colours.rgba[4 * i + 3], 0);
            }
            if (is_composed) continue; // whose field owns which is for CSG's own tests
            const double field_t = ball_t(ray_of(i), {0.1, 0, 0}, 0.6);
            field_pixels += owner == 1;
            const double slack = 20 * field_error; // where the ray grazes
            const bool is_field = field_t < seen[i].t;
            if (std::abs(field_t - seen[i].t) > slack && std::min(field_t, seen[i].t) < nowhere) {
                EXPECT_EQ(owner, is_field ? 1 : primitive_owner) << i;
            }
        }
        EXPECT_GT(primitive_pixels, 1000);
        if (!is_composed) {
            EXPECT_GT(field_pixels, 1000);
        }
    }
}

TEST_F(SplatScenes, FieldMoleculeAndMeshIntersectAlongTheRightCurves) {
    size = 320;
    // A ball as a field, atoms and bonds, and a torus of 6,000 triangles that passes through all.
    const Vec3d centre(0.1, 0, 0);
    const double radius = 0.6;
    Primitives primitives;
    for (const Vec3d& atom : {Vec3d(0.6, 0.1, 0.2), Vec3d(-0.4, 0.3, 0.4), Vec3d(0.1, 0.7, 0.3)}) {
        primitives.spheres.push_back({.centre_world = atom, .radius_world = 0.25});
        primitives.cylinders.push_back(
            {.a_world = atom, .b_world = Vec3d(0, -0.2, 0.5), .radius_world = 0.1});
    }
    const Mesh torus = sample_mesh("torus");
    TriangleMesh mesh{.vertices_world = torus.vertices_world, .triangles = torus.triangles};
    Eigen::AlignedBox3d box;
    for (const Vec3d& vertex : mesh.vertices_world) box.extend(vertex);
    for (Vec3d& vertex : mesh.vertices_world)
        vertex = Eigen::AngleAxisd(0.5, Vec3d::UnitX()) * (1.8 / box.sizes().maxCoeff() * vertex);
    primitives.meshes = {mesh};
    number_by_colour(primitives);
    Scene scene{.primitives = std::make_shared<Primitives>(primitives)};
    scene.objects.push_back({.field = sampled(sphere_field(centre, radius), 64)});
    renderer.load(scene);
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        renderer.draw(camera, size, size, {FrameImage::Hit, FrameImage::SplatColour});
        const Image hits = renderer.read(FrameImage::Hit);
        const Image colours = renderer.read(FrameImage::SplatColour);
        const std::vector<SeenPrimitive> seen = cast_primitives(primitives, camera, size, size);
        // As above: where the field's own error, along rays that graze, may decide.
        const double slack = 20 * 3 * 15 / std::pow(radius, 3) / 192 * std::pow(2.0 / 63, 4);
        int wrong = 0;
        int undecided = 0;
        std::array<int, 4> shown{}; // field, spheres, sticks, triangles
        for (std::size_t i = 0; i < seen.size(); ++i) {
            const double field_t = ball_t(ray_of(i), centre, radius);
            const double first = std::min(field_t, seen[i].t);
            if (first < nowhere && std::abs(field_t - seen[i].t) <= slack) {
                ++undecided;
                continue;
            }
            const bool is_field = field_t < seen[i].t;
            const int number = first == nowhere || is_field ? -1 : seen[i].number;
            const double owner = first == nowhere ? 0 : is_field ? 1 : 2;
            wrong +=
                hits.rgba[4 * i + 3] != owner || number_of_colour(&colours.rgba[4 * i]) != number;
            if (owner != 0) ++shown[is_field ? 0 : number < 3 ? 1 : number < 6 ? 2 : 3];
        }
        EXPECT_EQ(wrong, 0);
        EXPECT_LT(undecided, 10);
        for (const int count : shown) EXPECT_GT(count, 500);
    }
}

TEST_F(SplatScenes, CurvaturesAreThoseOfTheQuadrics) {
    Primitives primitives = some_quadrics(random, 4);
    primitives.cylinders.push_back({.a_world = {0.5, 0.7, 2},
                                    .b_world = {0.6, 0.8, 2.5},
                                    .radius_world = 0.2,
                                    .is_capped = true});
    number_by_colour(primitives);
    renderer.load({.primitives = std::make_shared<Primitives>(primitives)});
    renderer.draw(
        camera, size, size,
        {FrameImage::Hit, FrameImage::SplatColour, FrameImage::Curvature, FrameImage::Direction});
    const Image curvatures = renderer.read(FrameImage::Curvature);
    const Image directions = renderer.read(FrameImage::Direction);
    const std::vector<SeenPrimitive> seen = cast_primitives(primitives, camera, size, size);
    std::vector<Quadric> quadrics;
    const auto append = [&](const auto& of_kind) {
        for (const auto& one : of_kind) quadrics.push_back(quadric_of(one));
    };
    append(primitives.spheres);
    append(primitives.ellipsoids);
    append(primitives.cylinders);
    append(primitives.cones);
    append(primitives.quadrics);
    int compared = 0;
    int caps = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const float* drawn = &curvatures.rgba[4 * i];
        EXPECT_EQ(drawn[3] != 0, seen[i].number >= 0);
        if (seen[i].number < 0) continue;
        const Quadric& quadric = quadrics[static_cast<std::size_t>(seen[i].number)];
        const Ray ray = ray_of(i);
        const Vec3d p = ray.origin_world + seen[i].t * ray.direction_world;
        const QuadricDerivatives d = derivatives(quadric, p);
        const Vec3d outward = d.gradient.normalized();
        if ((outward - seen[i].normal).norm() > 1e-6) { // a cap is flat
            EXPECT_EQ(drawn[0], 0);
            EXPECT_EQ(drawn[1], 0);
            ++caps;
            continue;
        }
        const Curvatures k = principal_curvatures(d.gradient, d.hessian);
        // Float positions are off by 1e-6 of the eye's distance, of which curvatures' own scale
        // is a share: 5 / 0.02 radii; near a cone's apex they grow without bounds.
        const double scale = std::max({std::abs(k.k1), std::abs(k.k2), 0.1});
        if (scale > 100) continue;
        EXPECT_NEAR(drawn[0], k.k1, 2e-3 * scale) << seen[i].number;
        EXPECT_NEAR(drawn[1], k.k2, 2e-3 * scale) << seen[i].number;
        if (k.k1 - k.k2 > 0.2 * scale) {
            const Vec3d direction(directions.rgba[4 * i], directions.rgba[4 * i + 1],
                                  directions.rgba[4 * i + 2]);
            EXPECT_GT(std::abs(direction.dot(k.direction1)), std::cos(0.02)) << seen[i].number;
        }
        if (seen[i].number < 4) {
            EXPECT_EQ(drawn[3], 3); // umbilics all over a sphere
        }
        ++compared;
    }
    EXPECT_GT(compared, 2000);
    EXPECT_GT(caps, 20);
}

TEST_F(SplatScenes, PartsAreTheWholePicture) {
    const auto primitives = std::make_shared<Primitives>(some_quadrics(random, 5));
    Look look;
    look.lights[0].shadow = Shadow::Soft;
    renderer.load({.look = look, .primitives = primitives});
    renderer.draw(camera, size, size, {FrameImage::Beauty, FrameImage::Hit});
    const Image whole = renderer.read(FrameImage::Beauty);
    for (const PicturePart& part : {PicturePart{.x = 3, .y = 17, .width = 61, .height = 44},
                                    PicturePart{.x = 100, .y = 90, .width = 60, .height = 70}}) {
        renderer.draw(camera, size, size, {FrameImage::Beauty}, part);
        const Image drawn = renderer.read(FrameImage::Beauty);
        for (int y = 0; y < part.height; ++y)
            for (int x = 0; x < part.width; ++x)
                for (int channel = 0; channel < 4; ++channel)
                    ASSERT_EQ(
                        drawn.rgba[static_cast<std::size_t>(4 * (y * part.width + x) + channel)],
                        whole.rgba[static_cast<std::size_t>(4 * ((y + part.y) * size + x + part.x) +
                                                            channel)])
                        << x << ", " << y;
    }
}

TEST_F(SplatScenes, RunOnlyWhatIsAsked) {
    Primitives spheres;
    spheres.spheres = {{}, {.centre_world = {1, 1, 0}}};
    renderer.load({.primitives = std::make_shared<Primitives>(spheres)});
    FrameReport report = renderer.draw(camera, size, size, {FrameImage::Hit});
    for (const PassReport& p : report.passes)
        EXPECT_EQ(p.ran, p.name == "splats" || p.name == "raycast") << p.name;
    EXPECT_EQ(report.programs_compiled, 2); // splats of spheres, and their hits
    EXPECT_EQ(report.field_bytes, 0);

    report = renderer.draw(camera, size, size, {FrameImage::Beauty});
    for (const PassReport& p : report.passes)
        EXPECT_EQ(p.ran, p.name == "splat surfaces" || p.name == "shading") << p.name;
    EXPECT_EQ(report.programs_compiled, 4);               // their surfaces, and shading
    EXPECT_EQ(report.image_bytes, size * size * (8 + 8)); // surfaces of splats and the picture

    Look look;
    look.effects.outlines.strength = 1;
    renderer.set_look(look);
    report = renderer.draw(camera, size, size, {FrameImage::Beauty});
    int ran = 0;
    for (const PassReport& p : report.passes) ran += p.ran && p.drawn_by.empty();
    EXPECT_EQ(ran, 5); // splats, hits with colours and normals, outlines and their source, shading

    // A field alone knows nothing of primitives.
    Renderer other(*context, shader_folder);
    other.load({.field = sampled(sphere_field(Vec3d::Zero(), 0.6), 32)});
    report = other.draw(camera, size, size, {FrameImage::Beauty});
    EXPECT_FALSE(pass(report, "splats").ran);
    EXPECT_FALSE(pass(report, "splat colour").ran);
    EXPECT_EQ(report.splat_bytes, 0);
}

TEST_F(SplatScenes, AreShadedAtOnceAsThroughHitsAndNormals) {
    Scene scene{.primitives = std::make_shared<Primitives>(some_of_each(random, 12)),
                .cut = {.planes = {{.normal = {0.3, 0.2, 1}, .offset_world = 0.4}}}};
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic})
        for (const CutLook cut : {CutLook::Inside, CutLook::Capped})
            for (const ShadingModel model :
                 {ShadingModel::BlinnPhong, ShadingModel::Gooch, ShadingModel::Flat}) {
                camera.projection = projection;
                scene.cut.look = cut;
                scene.look.model = model;
                scene.look.effects.contours.strength = 0;
                renderer.load(scene);
                FrameReport report = renderer.draw(camera, size, size, {FrameImage::Beauty});
                EXPECT_FALSE(pass(report, "raycast").ran);
                const Image at_once = renderer.read(FrameImage::Beauty);
                // An effect that reads hits and adds nothing.
                scene.look.effects.contours.strength = 1e-30;
                renderer.set_look(scene.look);
                report = renderer.draw(camera, size, size, {FrameImage::Beauty});
                EXPECT_TRUE(pass(report, "raycast").ran);
                const Image through_hits = renderer.read(FrameImage::Beauty);
                int covered = 0;
                for (std::size_t i = 0; i < at_once.rgba.size(); ++i) {
                    covered += i % 4 == 3 && at_once.rgba[i] > 0;
                    // Colours come from halves there, and highlights amplify roundings.
                    ASSERT_NEAR(at_once.rgba[i], through_hits.rgba[i],
                                0x1p-10 * (1 + std::abs(through_hits.rgba[i])));
                }
                EXPECT_GT(covered, 5000);
            }
}

TEST_F(SplatScenes, SticksOfTwoColoursChangeInTheirMiddle) {
    Primitives some;
    some.spheres = {random.sphere()}; // so that numbers do not begin with sticks
    some.cones = {random.cone()};     // which the same shader draws
    for (int i = 0; i < 40; ++i) {
        some.cylinders.push_back(random.cylinder());
        some.cylinders.back().radius_world *= 0.3;
    }
    number_by_colour(some);
    constexpr int other_half = 100;
    for (std::size_t i = 0; i < some.cylinders.size(); ++i)
        if (i % 4 != 0) // the others have one colour
            some.cylinders[i].colour_b = colour_of_number(static_cast<int>(i) + 1 + other_half);
    for (const CutLook look : {CutLook::Inside, CutLook::Capped}) {
        const Cut cut{.look = look, .planes = {{.normal = {0.3, 0.2, 1}, .offset_world = 0.2}}};
        renderer.load({.primitives = std::make_shared<Primitives>(some), .cut = cut});
        renderer.draw(camera, size, size, {FrameImage::SplatColour});
        const Image colours = renderer.read(FrameImage::SplatColour);
        const std::vector<SeenPrimitive> seen = cast_primitives(some, camera, size, size, cut);
        int halves = 0;
        for (std::size_t i = 0; i < seen.size(); ++i) {
            int expected = seen[i].number;
            if (expected >= 1 && expected <= 40) {
                const Cylinder& stick = some.cylinders[static_cast<std::size_t>(expected) - 1];
                const Ray ray = ray_of(i);
                const Vec3d p = ray.origin_world + seen[i].t * ray.direction_world;
                const Vec3d axis = stick.b_world - stick.a_world;
                const double past = (p - (stick.a_world + stick.b_world) / 2).dot(axis);
                if (std::abs(past) < 1e-5 * axis.squaredNorm()) continue; // either colour
                if (past > 0 && stick.colour_b) expected += other_half;
                halves += past > 0 && stick.colour_b;
            }
            ASSERT_EQ(number_of_colour(&colours.rgba[4 * i]), expected) << i;
        }
        EXPECT_GT(halves, 1000);
    }
}

TEST_F(SplatScenes, HardShadowsAreThoseOfRaysToTheLight) {
    Primitives scene;
    scene.cylinders = {
        {.a_world = {0, -1, 0}, .b_world = {0, -0.6, 0}, .radius_world = 1.2, .is_capped = true}};
    scene.spheres = {{.centre_world = {0.1, 0, 0}, .radius_world = 0.3},
                     {.centre_world = {-0.5, -0.3, 0.3}, .radius_world = 0.2}};
    const Vec3d light = Vec3d(0.4, 1, 0.3).normalized();
    camera.eye_world = {1, 2.5, 4};
    // A texel is 2.4 / 160 of the world, and bilinear weights reach one and a half of them.
    const double texel = 3.0 / size;
    const auto is_lit = [&](const Vec3d& p) -> std::optional<bool> {
        double clearance = nowhere; // of the way to the light from the spheres; < 0: blocked
        for (const Sphere& sphere : scene.spheres) {
            const Vec3d to_centre = sphere.centre_world - p;
            const double past = (to_centre - to_centre.dot(light) * light).norm();
            clearance = std::min(clearance, past - sphere.radius_world);
        }
        if (std::abs(clearance) < 2 * texel) return std::nullopt;
        return clearance > 0;
    };
    constexpr int cylinder = 2; // whose number comes after the spheres'
    const auto [dark, lit] =
        judge_hard_shadows(renderer, scene, light, camera, size, cylinder, is_lit);
    EXPECT_GT(dark, 100);
    EXPECT_GT(lit, 1000);
}

} // namespace
} // namespace isocast::test
