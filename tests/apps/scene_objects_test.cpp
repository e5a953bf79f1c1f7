// Objects of scenes: how they are composed, what is kept between frames, and pictures of solids
// whose surfaces are known.
// SPDX-License-Identifier: MPL-2.0
#include "apps/scene_objects.h"

#include "../volume/temporary_folder.h"
#include "exr_file.h"
#include "program.h"
#include "volume/analytic_fields.h"
#include "volume/files.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace isocast::test {
namespace {

using Json = nlohmann::json;
using Names = std::vector<std::string>;
constexpr auto Object = CsgOperation::Object;

SceneObject leaf(const std::string& name, std::optional<Vec3d> colour = {}) {
    SceneObject object;
    object.name = name;
    object.field = "field:sphere@8";
    object.colour = colour;
    return object;
}

SceneObject combined(const std::string& name, SceneObject::Csg csg, Names of) {
    SceneObject object;
    object.name = name;
    object.csg = csg;
    object.of = std::move(of);
    return object;
}

/// "a b + c -": operands before their operation, by their names.
std::string postfix(const SceneFile& scene, const Composition& composition) {
    std::string text;
    for (const CsgStep& step : composition.tree) {
        if (!text.empty()) text += ' ';
        const auto number = static_cast<std::size_t>(step.object);
        const bool is_object = step.operation == Object;
        const auto plane = is_object ? composition.parts.at(number).plane : std::nullopt;
        text += plane       ? fmt::format("plane.{}", *plane)
                : is_object ? name_of(scene, composition.parts.at(number).object)
                : step.operation == CsgOperation::Union        ? "+"
                : step.operation == CsgOperation::Intersection ? "*"
                                                               : "-";
    }
    return text;
}

TEST(Composition, UnitesWhatNoOtherObjectIsMadeOf) {
    SceneFile scene;
    scene.objects = {leaf("a"), leaf(""), leaf("c"), leaf("d")};
    EXPECT_EQ(postfix(scene, composition_of(scene)), "a object.1 + c + d +");
    SceneObject morph;
    morph.morph = {"a", "c"};
    scene.objects.push_back(morph);
    EXPECT_EQ(postfix(scene, composition_of(scene)), "object.1 d + object.4 +");
    scene.objects[1].is_shown = false;
    EXPECT_EQ(postfix(scene, composition_of(scene)), "d object.4 +");
    EXPECT_NO_THROW(check_scene(scene));
    scene.objects[0].is_shown = false;
    EXPECT_THROW(check_scene(scene), InputError) << "an operand";
    scene.objects = {leaf("a")};
    EXPECT_EQ(postfix(scene, composition_of(scene)), "a");
    scene.objects[0].is_shown = false;
    EXPECT_THROW(check_scene(scene), InputError) << "nothing is left";
}

TEST(Composition, TakesAwayFromEachObjectWhatPlanesCut) {
    const Vec3d red(1, 0, 0);
    SceneFile scene;
    scene.objects = {leaf("a"), leaf("b", red), leaf("c"), leaf("d"),
                     combined("e", SceneObject::Csg::Union, {"c", "d"})};
    scene.objects[1].is_cut = false;
    scene.cut.planes.resize(2);
    const std::string text = "a plane.0 - plane.1 - b + c d + plane.0 - plane.1 - +";
    EXPECT_EQ(postfix(scene, composition_of(scene)), text);
    EXPECT_EQ(composition_of(scene).parts.size(), 6U) << "planes of one colour are one part";
    scene.objects[4].cut_colour = red;
    EXPECT_EQ(postfix(scene, composition_of(scene)), text);
    const Composition composition = composition_of(scene);
    ASSERT_EQ(composition.parts.size(), 8U);
    EXPECT_EQ(composition.parts.back().colour, red);
    EXPECT_EQ(composition.parts[1].colour, std::nullopt);
    // Nine are too many.
    EXPECT_NO_THROW(check_scene(scene));
    scene.cut.planes.resize(3);
    EXPECT_THROW(check_scene(scene), InputError);
    scene.cut.planes.resize(1);
    scene.cut.near_world = 1;
    EXPECT_THROW(check_scene(scene), InputError) << "there are no primitives";
    scene.cut.near_world.reset();
    scene.objects[2].is_cut = false;
    EXPECT_THROW(check_scene(scene), InputError) << "an operand";
}

TEST(Composition, NestsTreesAndHasEachFieldOnce) {
    using Csg = SceneObject::Csg;
    SceneFile scene;
    scene.objects = {combined("all", Csg::Difference, {"both", "c", "d"}),
                     leaf("a"),
                     leaf("b"),
                     leaf("c"),
                     leaf("d"),
                     combined("both", Csg::Intersection, {"a", "b"}),
                     combined("more", Csg::Union, {"c", "both"})};
    const Composition composition = composition_of(scene);
    EXPECT_EQ(postfix(scene, composition), "a b * c - d - c a b * + +");
    EXPECT_EQ(composition.parts.size(), 4U);
    EXPECT_NO_THROW(check_tree(composition.tree, 4));
}

TEST(Composition, ColoursOfACsgAreForObjectsThatHaveNone) {
    const Vec3d red(1, 0, 0), blue(0, 0, 1), grey(0.5, 0.5, 0.5);
    SceneFile scene;
    scene.objects = {leaf("a", red), leaf("b"), leaf("c"),
                     combined("inner", SceneObject::Csg::Union, {"a", "b"}),
                     combined("outer", SceneObject::Csg::Difference, {"inner", "c"})};
    scene.objects[3].colour = blue;
    scene.objects[4].colour = grey;
    scene.objects[4].cut_colour = red;
    const std::vector<ScenePart> parts = composition_of(scene).parts;
    ASSERT_EQ(parts.size(), 3U);
    EXPECT_EQ(parts[0].colour, red);
    EXPECT_EQ(parts[1].colour, blue);
    EXPECT_EQ(parts[2].colour, grey);
    for (const ScenePart& part : parts) EXPECT_EQ(part.cut_colour, red);
}

struct ObjectScenes : testing::Test {
    TemporaryFolder folder;
    static constexpr const char* camera = "[camera]\neye = [1, 2, 6]\ntarget = [0, 0, 0]\n";

    /// A ball's distances in [-1.5, 1.5]^3, with no band.
    void write_ball(const std::string& name, const Vec3d& centre, double radius,
                    int samples = 32) const {
        AnalyticField ball = sphere_field(centre, radius);
        ball.half_extent_world = 1.5;
        write_dense(*sampled(std::move(ball), samples), folder / name);
    }
    SceneFile scene(const std::string& text) const {
        write_text(folder / "scene.toml", text);
        SceneFile read = read_scene_file(folder / "scene.toml");
        check_scene(read);
        return read;
    }
    /// Draws a scene, and returns what the program says.
    Outcome render(const std::string& text, const std::string& output,
                   const std::vector<std::string>& more = {}) const {
        write_text(folder / "scene.toml", text);
        return render_inputs({folder / "scene.toml"}, output, more);
    }
    Outcome render_inputs(std::vector<std::string> arguments, const std::string& output,
                          const std::vector<std::string>& more = {}) const {
        arguments.insert(arguments.begin(), "render");
        arguments.insert(arguments.end(), {"-o", folder / output, "--backend", "osmesa"});
        arguments.insert(arguments.end(), more.begin(), more.end());
        if (std::ranges::find(more, "--size") == more.end())
            arguments.insert(arguments.end(), {"--size", "48x32"});
        return isocast(arguments);
    }
    std::string picture(const std::string& text, const std::vector<std::string>& more = {}) const {
        checked_output(render(text, "a.png", more));
        return contents_of(folder / "a.png");
    }
};

Scene composed(SceneObjects& objects, const SceneFile& scene) {
    objects.open(scene);
    return objects.compose(scene, {}, [](const std::string&) {});
}

TEST_F(ObjectScenes, KeepConvertedMeshesFromFrameToFrame) {
    SceneFile now = scene("[[object]]\nname = \"a\"\nmesh = \"mesh:torus\"\nresolution = 16\n"
                          "[[object]]\nname = \"b\"\nmesh = \"mesh:knot\"\nresolution = 16\n"
                          "[[object]]\nmorph = [\"a\", \"b\"]\n");
    SceneObjects objects;
    const auto at = [&](double t) {
        now.objects[2].t = t;
        return composed(objects, now).objects.at(0).field;
    };
    const auto first = at(0);
    const auto last = at(1);
    EXPECT_NE(at(0.5), first);
    EXPECT_EQ(at(0), first);
    EXPECT_EQ(at(1), last);
    now.objects[1].resolution = 12;
    EXPECT_NE(at(1), last);
    EXPECT_EQ(at(0), first);
}

TEST_F(ObjectScenes, KeepFilesOfASeriesWhileTheyComeAgain) {
    for (const int time : {0, 1, 2})
        write_ball(fmt::format("f_{}.nrrd", time), Vec3d::Zero(), 0.5 + 0.1 * time, 8);
    SceneFile now = scene("[[object]]\nseries = \"f_#.nrrd\"\n");
    SceneObjects objects;
    const auto at = [&](double time) {
        now.objects[0].time = time;
        return composed(objects, now).objects.at(0).field;
    };
    const std::weak_ptr<const FieldSource> first = at(0);
    const std::weak_ptr<const FieldSource> second = at(1);
    EXPECT_TRUE(first.expired()) << "only one file is needed at its own time";
    at(1.5);
    EXPECT_EQ(at(1), second.lock());
    EXPECT_EQ(at(0.1 + 0.2 + 0.7), second.lock()) << "times of frames are rounded numbers";
    EXPECT_EQ(at(1 + 1e-15), second.lock());
    at(2);
    EXPECT_TRUE(second.expired());
}

TEST_F(ObjectScenes, IsoValuesOfAMorphLieBetweenThoseOfItsObjects) {
    SceneFile now = scene("[[object]]\nname = \"a\"\nfield = \"field:sphere@8\"\niso = 0.5\n"
                          "[[object]]\nname = \"b\"\nfield = \"field:torus@8\"\niso = -0.5\n"
                          "[[object]]\nmorph = [\"a\", \"b\"]\nt = 0.25\n");
    SceneObjects objects;
    EXPECT_EQ(composed(objects, now).objects.at(0).iso_world, 0.25);
    now.objects[2].iso_world = 0.75;
    EXPECT_EQ(composed(objects, now).objects.at(0).iso_world, 0.75);
}

/// The pixels of a picture of 64x64, 2.5 high, from where parallel rays look down -z: their number
/// and place.
template<class Visit>
void for_each_ray(const Visit& visit) {
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            visit(static_cast<std::size_t>(64 * y + x), 2.5 * ((x + 0.5) / 64 - 0.5),
                  2.5 * (0.5 - (y + 0.5) / 64));
}

/// Where the second ball comes from: a file, a morph or a series. Blends of distances to concentric
/// spheres are those to the sphere of the blended radius.
class DifferenceOfBalls : public ObjectScenes, public testing::WithParamInterface<const char*> {};
INSTANTIATE_TEST_SUITE_P(
    Sources, DifferenceOfBalls,
    testing::Values(
        "[[object]]\nname = \"b\"\nfield = \"b_06.nrrd\"\niso = 0\n",
        "[[object]]\nname = \"b\"\nmorph = [\"c\", \"d\"]\nt = 0.5\n"
        "[[object]]\nname = \"c\"\nfield = \"b_05.nrrd\"\niso = 0\n"
        "[[object]]\nname = \"d\"\nfield = \"b_07.nrrd\"\niso = 0\n",
        "[[object]]\nname = \"b\"\nseries = \"b_##.nrrd\"\ntime = 5.25\niso = 0.075\n"));

TEST_P(DifferenceOfBalls, HasTheSolidsSurfaceAndColours) {
    const Vec3d centre_b(0.3, 0.2, 0.8);
    write_ball("a.nrrd", Vec3d::Zero(), 1);
    for (const int tenths : {5, 6, 7})
        write_ball(fmt::format("b_0{}.nrrd", tenths), centre_b, tenths / 10.0);
    // 5.25 has the radius 0.525, and at the iso value 0.075 it is 0.6.
    const std::string text = "[[object]]\nname = \"a\"\nfield = \"a.nrrd\"\niso = 0\n"
                             "[[object]]\ncsg = \"difference\"\nof = [\"a\", \"b\"]\n"
                             "colour = [1, 0.5, 0.25]\ncut_colour = [0.25, 0.5, 1]\n"
                             "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nheight = 2.5\n"
                             "[shading]\nmodel = \"flat\"\n";
    checked_output(render(text + GetParam(), "a.exr", {"--aov", "P,id", "--size", "64x64"}));
    const ExrFile exr(folder / "a.exr");
    int hits = 0, expected_hits = 0, cuts = 0;
    for_each_ray([&](std::size_t i, double px, double py) {
        // Along the ray, which looks down -z: from the front of a, or behind b.
        const double in_a = 1 - px * px - py * py;
        const double in_b = 0.36 - Eigen::Vector2d(px - 0.3, py - 0.2).squaredNorm();
        double z = std::sqrt(std::max(in_a, 0.0));
        const bool is_cut = in_b > 0 && z < 0.8 + std::sqrt(in_b) && z > 0.8 - std::sqrt(in_b);
        if (is_cut) z = 0.8 - std::sqrt(in_b);
        const bool is_solid = in_a > 0 && z > -std::sqrt(in_a);
        expected_hits += is_solid;
        const float id = exr.channels.at("id")[i];
        if (id == 0) return;
        ++hits;
        cuts += id == 2;
        const Vec3d p = exr.vector("P", i);
        const double a = p.norm() - 1;
        const double b = (p - centre_b).norm() - 0.6;
        // Terms of fourth order, (h/r)^3 = 4e-3 voxels times a small factor; voxels of 0.097.
        EXPECT_NEAR(std::max(a, -b), 0, 1e-4) << i;
        EXPECT_EQ(id, a > -b ? 1 : 2);
        EXPECT_EQ(exr.channels.at("R")[i], id == 1 ? 1.0F : 0.25F);
        EXPECT_EQ(exr.channels.at("B")[i], id == 1 ? 0.25F : 1.0F);
    });
    // The outline is some 200 pixels long; of these the centre lies within 1e-3 pixel of it by
    // chance only.
    EXPECT_NEAR(hits, expected_hits, 1);
    EXPECT_GT(cuts, 300);
    EXPECT_GT(hits - cuts, 300);
}

TEST_F(ObjectScenes, PlanesCutBallsFlatAndKeepTheirFieldsWhileTheyMove) {
    write_ball("a.nrrd", Vec3d::Zero(), 1);
    const std::string text = "[[object]]\nfield = \"a.nrrd\"\niso = 0\ncut_colour = [0, 0, 1]\n"
                             "colour = [1, 0, 0]\n[[cut.plane]]\nnormal = [3, 0, 4]\n"
                             "offset = 0.4\n"
                             "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nheight = 2.5\n"
                             "[shading]\nmodel = \"flat\"\n";
    checked_output(render(text, "a.exr", {"--aov", "P,N,id", "--size", "64x64"}));
    const ExrFile exr(folder / "a.exr");
    int hits = 0, caps = 0, expected_hits = 0;
    for_each_ray([&](std::size_t i, double px, double py) {
        const double root = std::sqrt(std::max(1 - px * px - py * py, 0.0));
        const double z_plane = (0.4 - 0.6 * px) / 0.8;
        const bool is_solid = root > 0 && z_plane > -root;
        expected_hits += is_solid;
        const float id = exr.channels.at("id")[i];
        if (id == 0) return;
        ++hits;
        const bool is_cap = id == 2;
        caps += is_cap;
        const Vec3d p = exr.vector("P", i);
        if (is_cap) {
            // 1e-5 of the plane's cells, 1/64 of the ball's box of 3; and float's rounding of
            // places and normals.
            EXPECT_NEAR(Vec3d(0.6, 0, 0.8).dot(p), 0.4, 1e-6);
            EXPECT_LT((exr.vector("N", i) - Vec3d(0.6, 0, 0.8)).norm(), 1e-5);
            EXPECT_LT(p.norm(), 1 + 1e-4);
        } else {
            EXPECT_NEAR(p.norm(), 1, 1e-4); // as of DifferenceOfBalls
            EXPECT_LT(0.6 * p.x() + 0.8 * p.z(), 0.4 + 1e-6);
        }
        EXPECT_EQ(exr.channels.at("R")[i], is_cap ? 0.0F : 1.0F);
        EXPECT_EQ(exr.channels.at("B")[i], is_cap ? 1.0F : 0.0F);
    });
    EXPECT_NEAR(hits, expected_hits, 1); // as of DifferenceOfBalls
    EXPECT_GT(caps, 300);
    EXPECT_GT(hits - caps, 300);

    SceneFile now = scene(text);
    SceneObjects objects;
    const Scene before = composed(objects, now);
    now.cut.planes[0].offset_world = 0.5;
    const Scene after = composed(objects, now);
    EXPECT_EQ(before.objects[1].field, after.objects[1].field);
    EXPECT_NEAR(before.objects[1].iso_world - after.objects[1].iso_world, 0.1, 1e-15);
    now.objects[0].is_cut = false;
    EXPECT_EQ(composed(objects, now).objects.size(), 1U);
}

TEST_F(ObjectScenes, AreScaledTurnedAndMoved) {
    write_ball("a.nrrd", {0.5, 0.25, 0}, 0.6);
    const std::string placed = "scale = 2\nrotate = [0, 0, 90]\ntranslate = [10, 0, 1]\n";
    const std::string text = "[[object]]\nname = \"a\"\nfield = \"a.nrrd\"\niso = 0.1\n" + placed;
    checked_output(render(text, "a.exr", {"--aov", "P"}));
    const ExrFile exr(folder / "a.exr");
    int hits = 0;
    for (std::size_t i = 0; i < exr.channels.at("Z").size(); ++i) {
        if (std::isinf(exr.channels.at("Z")[i])) continue;
        ++hits;
        // A quarter turn takes (1, 0.5, 0) to (-0.5, 1, 0). As above, of voxels twice as large.
        EXPECT_NEAR((exr.vector("P", i) - Vec3d(9.5, 1, 1)).norm(), 2 * (0.6 + 0.1), 2e-4);
    }
    EXPECT_GT(hits, 200);

    // What was placed is kept from frame to frame, and with it what was made of it.
    const SceneFile now = scene(text + "[[object]]\nname = \"b\"\nfield = \"field:sphere@8\"\n" +
                                placed + "[[object]]\ncsg = \"union\"\nof = [\"a\", \"b\"]\n");
    SceneObjects objects;
    const Scene first = composed(objects, now);
    EXPECT_EQ(first.objects[0].iso_world, 0.2);
    EXPECT_EQ(first.objects[0].field, composed(objects, now).objects[0].field);
    SceneFile moved = now;
    moved.objects[0].placement.translation_world.x() = 11;
    EXPECT_NE(first.objects[0].field, composed(objects, moved).objects[0].field);
    EXPECT_EQ(first.objects[1].field, composed(objects, moved).objects[1].field);

    const Outcome refused = render("[[object]]\nname = \"a\"\nfield = \"a.nrrd\"\n"
                                   "[[object]]\nname = \"b\"\nfield = \"a.nrrd\"\n"
                                   "[[object]]\ncsg = \"union\"\nof = [\"a\", \"b\"]\nscale = 2\n",
                                   "a.png");
    EXPECT_EQ(refused.code, 3);
    EXPECT_NE(refused.err.find("scene.toml:10:9: "), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("a csg has none"), std::string::npos) << refused.err;
}

TEST(Composition, RefusesTreesThatGrowWithoutEnd) {
    SceneFile scene;
    scene.objects = {leaf("0")};
    for (int i = 1; i < 64; ++i)
        scene.objects.push_back(combined(std::to_string(i), SceneObject::Csg::Union,
                                         {std::to_string(i - 1), std::to_string(i - 1)}));
    EXPECT_THROW(composition_of(scene), InputError);
}

TEST_F(ObjectScenes, UniteObjectsEachWithItsColour) {
    write_ball("a.nrrd", {-0.6, 0, 0}, 0.8);
    write_ball("b.nrrd", {0.6, 0, 0}, 0.7);
    const std::string rest = "[camera]\neye = [0, 1, 6]\ntarget = [0, 0, 0]\n"
                             "[shading]\nmodel = \"flat\"\ncolour = [0.25, 1, 0]\n";
    const Json json = Json::parse(
        checked_output(render("[[object]]\nfield = \"a.nrrd\"\niso = 0\ncolour = [1, 0, 0.5]\n"
                              "[[object]]\nname = \"right\"\nfield = \"b.nrrd\"\niso = 0\n" +
                                  rest,
                              "a.exr", {"--aov", "P,id", "--json"})));
    EXPECT_EQ(json["objects"].size(), 2U);
    EXPECT_EQ(json["objects"][0]["name"], "object.0");
    EXPECT_EQ(json["objects"][1]["name"], "right");
    EXPECT_EQ(json["asked"][0], "2 objects");
    const ExrFile exr(folder / "a.exr");
    std::array<int, 3> counts{};
    for (std::size_t i = 0; i < exr.channels.at("id").size(); ++i) {
        const auto id = static_cast<std::size_t>(exr.channels.at("id")[i]);
        ++counts.at(id);
        if (id == 0) continue;
        EXPECT_EQ(exr.channels.at("R")[i], id == 1 ? 1.0F : 0.25F);
        EXPECT_EQ(exr.channels.at("G")[i], id == 1 ? 0.0F : 1.0F);
        const Vec3d p = exr.vector("P", i);
        const Vec3d centre(id == 1 ? -0.6 : 0.6, 0, 0);
        EXPECT_NEAR((p - centre).norm(), id == 1 ? 0.8 : 0.7, 1e-4); // as above
    }
    for (const int count : counts) EXPECT_GT(count, 100);
}

TEST_F(ObjectScenes, OfSeveralInputsAreThoseOfTheSameObjects) {
    write_ball("a.nrrd", {-0.6, 0, 0}, 0.8);
    const std::string by_scene =
        picture("[[object]]\nfield = \"a.nrrd\"\niso = 0.125\n"
                "[[object]]\nmesh = \"mesh:torus\"\nresolution = 24\niso = 0.125\n");
    checked_output(render_inputs({folder / "a.nrrd", "mesh:torus"}, "b.png",
                                 {"--resolution", "24", "--iso", "0.125"}));
    EXPECT_EQ(contents_of(folder / "b.png"), by_scene);
    write_text(folder / "scene.toml", "");
    const Outcome refused = render_inputs({"mesh:torus", folder / "scene.toml"}, "c.png");
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.err.find("stands alone"), std::string::npos) << refused.err;
    EXPECT_EQ(render_inputs({"field:torus@8", "field:cube@8"}, "c.png", {"--resolution", "9"}).code,
              2);
}

TEST_F(ObjectScenes, OfOneFieldNeedNoComposition) {
    const Json json = Json::parse(checked_output(render(
        "[[object]]\nfield = \"field:torus@16\"\ncolour = [1, 0, 0]\n", "a.png", {"--json"})));
    EXPECT_EQ(json["programs"], 2) << "hits with gradients, and shading";
    EXPECT_EQ(json["notes"], Json::array());
    EXPECT_EQ(json["objects"].size(), 1U);
}

TEST_F(ObjectScenes, MorphsAreTheirObjectsAtTheEnds) {
    write_ball("a.nrrd", {-0.3, 0, 0}, 0.9, 24);
    write_ball("b.nrrd", {0.3, 0, 0}, 0.6, 20); // another lattice
    const std::string a = "[[object]]\nname = \"a\"\nfield = \"a.nrrd\"\niso = 0.125\n";
    const std::string b = "[[object]]\nname = \"b\"\nfield = \"b.nrrd\"\n"; // what info suggests
    const std::string both = a + b + "[[object]]\nmorph = [\"a\", \"b\"]\n";
    EXPECT_EQ(picture(both + "t = 0\n" + camera), picture(a + camera));
    EXPECT_EQ(picture(both + "t = 1\n" + camera), picture(b + camera));
    EXPECT_NE(picture(both + "t = 0.5\n" + camera), picture(a + camera));
}

TEST_F(ObjectScenes, SeriesAreTheirFilesAtTheirTimesAndBlendsBetween) {
    write_ball("f_010.nrrd", {-0.3, 0, 0}, 0.9, 24);
    write_ball("f_014.nrrd", {0.3, 0, 0}, 0.6, 24);
    const std::string series = "[[object]]\nseries = \"f_###.nrrd\"\n";
    const std::string files = "[[object]]\nname = \"a\"\nfield = \"f_010.nrrd\"\n"
                              "[[object]]\nname = \"b\"\nfield = \"f_014.nrrd\"\n";
    EXPECT_EQ(picture(series + camera),
              picture("[[object]]\nfield = \"f_010.nrrd\"\n" + std::string(camera)));
    EXPECT_EQ(picture(series + "time = 14\n" + camera),
              picture("[[object]]\nfield = \"f_014.nrrd\"\n" + std::string(camera)));
    EXPECT_EQ(picture(series + "time = 11\n" + camera),
              picture(files + "[[object]]\nmorph = [\"a\", \"b\"]\nt = 0.25\n" + camera));
}

TEST_F(ObjectScenes, WarnWhereBandsDoNotMeet) {
    const std::string text = "[[object]]\nname = \"a\"\nmesh = \"mesh:sphere6\"\nresolution = 32\n"
                             "[[object]]\nname = \"b\"\nmesh = \"mesh:knot\"\nresolution = 32\n"
                             "[[object]]\nname = \"between\"\nmorph = [\"a\", \"b\"]\nt = 0.5\n";
    const Outcome narrow = render(text, "a.png");
    checked_output(narrow);
    EXPECT_NE(narrow.err.find("between: the bands of the two fields do not meet"),
              std::string::npos)
        << narrow.err;
    const Outcome wide =
        render(text, "a.png", {"--set", "object.0.band=32", "--set", "object.1.band=32"});
    checked_output(wide);
    EXPECT_EQ(wide.err, "");
}

TEST_F(ObjectScenes, SequencesOverMorphsEqualThePicturesOfEachFrameAlone) {
    const std::string objects = "[[object]]\nname = \"a\"\nmesh = \"mesh:torus\"\nresolution = 20\n"
                                "band = 20\n"
                                "[[object]]\nname = \"b\"\nfield = \"field:sphere@20\"\n"
                                "[[object]]\nmorph = [\"a\", \"b\"]\n";
    const std::string sequence = "[output]\nframes = 3\n[[animate]]\nkey = \"object.2.t\"\n";
    checked_output(render(objects + camera + sequence, "s%d.png"));
    std::string before;
    for (const int i : {0, 1, 2}) {
        const std::string frame = contents_of(folder / fmt::format("s{}.png", i));
        EXPECT_EQ(frame, picture(objects + fmt::format("t = {}\n", i / 2.0) + camera)) << i;
        EXPECT_NE(frame, before);
        before = frame;
    }
}

TEST_F(ObjectScenes, SequencesMoveTheIsoValueOfOneObjectAmongSeveral) {
    const std::string objects = "[[object]]\nfield = \"field:cylinder@20\"\n"
                                "[[object]]\nname = \"a\"\nfield = \"field:torus@20\"\n";
    checked_output(render(objects + camera +
                              "[output]\nframes = 2\n[[animate]]\nkey = \"object.1.iso\"\n"
                              "from = 0\nto = 0.125\n",
                          "s%d.png"));
    EXPECT_EQ(contents_of(folder / "s0.png"), picture(objects + "iso = 0\n" + camera));
    EXPECT_EQ(contents_of(folder / "s1.png"), picture(objects + "iso = 0.125\n" + camera));
}

TEST_F(ObjectScenes, SayThatNothingIsLeft) {
    const Outcome outcome =
        render("[[object]]\nname = \"a\"\nfield = \"field:torus@16\"\niso = 100\n"
               "[[object]]\nname = \"b\"\nfield = \"field:torus@16\"\n"
               "[[object]]\ncsg = \"intersection\"\nof = [\"a\", \"b\"]\n",
               "a.png");
    checked_output(outcome);
    EXPECT_NE(outcome.err.find("nothing is left"), std::string::npos) << outcome.err;
}

} // namespace
} // namespace isocast::test
