// The viewer by real mouse and keys, under Xvfb.
// SPDX-License-Identifier: MPL-2.0
#include "window_session.h"

#include "apps/scene_file.h"
#include "distance_transform/mesh_files.h"
#include "raycaster/image.h"
#include "stability/shapes.h"

#include <cmath>
#include <set>
#include <sstream>

namespace isocast::test {
namespace {

bool is_step(const Json& line) {
    return line.contains("step");
}
bool is_coarse(const Json& line) {
    return is_step(line) && line["step"] == "coarse";
}

/// Names of the passes that ran.
std::set<std::string> passes_of(const std::vector<Json>& lines) {
    std::set<std::string> names;
    for (const Json& line : lines)
        if (is_step(line))
            for (const auto& [name, milliseconds] : line["passes"].items()) names.insert(name);
    return names;
}

/// "k1 2.5" of a probe's text.
std::vector<double> numbers_of(const std::string& text, const std::string& word) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        if (line.starts_with(word + ' ')) {
            std::istringstream rest(line.substr(word.size()));
            std::vector<double> numbers;
            for (double number = 0; rest >> number;) numbers.push_back(number);
            return numbers;
        }
    ADD_FAILURE() << word << " is not in " << text;
    return {0, 0, 0};
}

TEST(View, ExploresATorus) {
    WindowSession session({"field:torus@64"});
    session.wait_for_rest();

    // A drag turns it: coarse pictures while it moves, whole ones after it.
    std::size_t mark = session.mark();
    session.drag(1, 700, 300, 830, 360);
    session.wait_until("a coarse picture", mark, is_coarse); // a busy machine is slow to answer
    session.wait_for_rest();
    const std::vector<Json> drag = session.trace_since(mark);
    EXPECT_TRUE(std::ranges::any_of(drag, is_coarse)); // how many is a matter of the machine
    EXPECT_TRUE(std::ranges::any_of(drag, [](const Json& line) {
        return is_step(line) && line["round"] == 4 && line["ends_round"];
    }));

    // At rest nothing is drawn.
    mark = session.mark();
    session.xdotool("sleep 1");
    EXPECT_EQ(session.mark(), mark);

    // A point of the torus, by its closed form: radii 1 and 0.4 about z.
    session.click("Probe");
    session.wait_for_rest();
    session.xdotool("mousemove 640 560 sleep 0.3 click 1");
    session.wait_until("a pin", 0, [](const Json& line) { return line.contains("pin"); });
    session.wait_for_rest();
    ASSERT_EQ(session.events("pin").size(), 1u);
    const std::string probe = session.events("pin").front();
    const auto p = numbers_of(probe, "position");
    const double rho = std::hypot(p[0], p[1]);
    EXPECT_NEAR(std::hypot(rho - 1, p[2]), 0.4, 4e-4); // 1e-3 of it, for three digits
    const double k1 = 1 / 0.4;
    const double k2 = (rho - 1) / (0.4 * rho);
    EXPECT_NEAR(numbers_of(probe, "k1")[0], std::max(k1, k2), 1e-3 * k1);
    EXPECT_NEAR(numbers_of(probe, "k2")[0], std::min(k1, k2), 1e-3 * k1);
    EXPECT_NEAR(numbers_of(probe, "|gradient|")[0], 1, 1e-3);
    const auto normal = numbers_of(probe, "normal");
    EXPECT_NEAR(normal[2], p[2] / 0.4, 1e-3);
    EXPECT_NEAR(normal[0] * p[1] - normal[1] * p[0], 0, 1e-3);
    session.click("Probe");

    // Colours by curvature: hits are kept.
    session.click("Effects");
    session.click("curvature colour", 0.1);
    session.wait_for_rest();
    mark = session.mark();
    session.click("effects.curvature_colour.0.strength", 0.4);
    session.wait_until("a picture", mark, is_step);
    session.wait_for_rest();
    std::vector<Json> first_round;
    for (const Json& line : session.trace_since(mark))
        if (is_step(line) && line["round"] == 0) first_round.push_back(line);
    EXPECT_EQ(passes_of(first_round),
              (std::set<std::string>{"curvature", "curvature colour", "shading"}));
    session.click("Effects");

    // Another iso value.
    mark = session.mark();
    session.click("iso", 0.3);
    session.wait_until("a picture", mark, is_step);
    session.wait_for_rest();
    EXPECT_TRUE(passes_of(session.trace_since(mark)).contains("raycast"));

    // The scene and the picture, saved: the program draws the same.
    session.xdotool("mousemove 1000 700 key ctrl+s");
    session.wait_for_rest();
    session.xdotool("key s");
    session.wait_until("a picture", 0, [](const Json& line) {
        return line.contains("message") && line["message"] == "saved isocast-1.png";
    });
    const auto scene = session.folder() / "isocast-1.toml";
    const auto picture = session.folder() / "isocast-1.png";
    ASSERT_TRUE(std::filesystem::exists(scene));
    ASSERT_TRUE(std::filesystem::exists(picture));
    EXPECT_NE(read_scene_file(scene).objects.front().iso_world, 0);
    checked_output(isocast({"render", scene, "-o", session.folder() / "again.png"}));
    const Image of_viewer = read_picture(picture);
    const Image again = read_picture(session.folder() / "again.png");
    ASSERT_EQ(again.width, of_viewer.width);
    ASSERT_EQ(again.height, of_viewer.height);
    float greatest = 0;
    for (std::size_t i = 0; i < again.rgba.size(); ++i)
        greatest = std::max(greatest, std::abs(again.rgba[i] - of_viewer.rgba[i]));
    EXPECT_EQ(greatest, 0) << "the same driver draws the same bits";

    session.close();
    EXPECT_EQ(session.wait_for_end(), 0);
}

TEST(View, TakesFilesThatAreDropped) {
    WindowSession session({"field:sphere@32"});
    session.wait_for_rest();
    const auto mesh = session.folder() / "a cube.obj";
    write_mesh(stability::scaled(stability::cube(), 0.7), mesh);
    std::size_t mark = session.mark();
    session.drop(mesh);
    session.wait_until("a scene of two", mark, [](const Json& line) {
        return line.contains("scene") && line["scene"] == "2 objects";
    });
    session.wait_for_rest();

    // What cannot be read is said, and what was there stays.
    write_text(session.folder() / "broken.obj", "v 1 2\n");
    mark = session.mark();
    session.drop(session.folder() / "broken.obj");
    session.wait_until("a message", mark, [](const Json& line) {
        return line.contains("message") &&
               line["message"].get<std::string>().find("broken.obj") != std::string::npos;
    });
    session.wait_for_rest();
    EXPECT_TRUE(session.is_running());

    // A file that is gone while it is open.
    std::filesystem::remove(mesh);
    mark = session.mark();
    session.drag(1, 700, 300, 730, 330, 5);
    session.wait_until("a picture", mark, is_step);
    session.wait_for_rest();
    session.interrupt();
    EXPECT_EQ(session.wait_for_end(), 130);
}

TEST(View, HidesObjectsCutsAndSlicesThem) {
    WindowSession session({"field:torus@48", "field:sphere@32"});
    session.wait_for_rest();
    int saved = 0;
    const auto scene = [&] {
        session.xdotool("mousemove 1000 600 key ctrl+s");
        const std::string name = "isocast-" + std::to_string(++saved) + ".toml";
        session.wait_until("a scene", 0, [&](const Json& line) {
            return line.contains("message") && line["message"] == "saved " + name;
        });
        return read_scene_file(session.folder() / name);
    };
    const auto wait_for_scenes = [&](std::size_t count) {
        session.wait_until("a scene", 0,
                           [&](const Json&) { return session.events("scene").size() == count; });
        session.wait_for_rest();
    };
    session.click("shown 1");
    wait_for_scenes(2);
    session.click("Cuts");
    session.wait_for_rest();
    session.click("one more plane");
    wait_for_scenes(3);
    session.click("Cuts");
    session.click("Objects");
    session.click("Effects");
    session.wait_for_rest();
    session.click("slice", 0.1);
    session.wait_for_rest();
    const std::size_t mark = session.mark();
    session.click("effects.slice.0.strength", 0.4);
    session.wait_until("a slice", mark, [](const Json& line) {
        return is_step(line) && line["passes"].contains("slice");
    });
    session.wait_for_rest();
    const SceneFile changed = scene();
    EXPECT_TRUE(changed.objects[0].is_shown);
    EXPECT_FALSE(changed.objects[1].is_shown);
    EXPECT_EQ(changed.cut.planes, std::vector<CutPlane>(1));
    EXPECT_GT(changed.look.effects.slice.strength, 0);
    EXPECT_EQ(session.events("scene").size(), 3u) << "the first, the hidden one, the cut one";

    // The right button makes it what it was.
    const auto place = session.place("effects.slice.0.strength");
    session.xdotool("mousemove " + std::to_string(int(place[0] + 20)) + ' ' +
                    std::to_string(int((place[1] + place[3]) / 2)) + " sleep 0.3 click 3");
    session.wait_for_rest();
    EXPECT_EQ(scene().look.effects.slice, Slice());
    session.close();
    EXPECT_EQ(session.wait_for_end(), 0);
}

TEST(View, CanBeClosedWhileItLoads) {
    WindowSession session({"mesh:sphere6", "--resolution", "1500"});
    session.xdotool("sleep 0.3");
    session.close();
    EXPECT_EQ(session.wait_for_end(), 0);
    EXPECT_TRUE(session.events("scene").empty()) << "it was loaded before it was closed";
}

TEST(View, WithoutADisplaySaysWhatElseThereIs) {
    const Outcome outcome = isocast({"view", "field:torus@16"}, {{"DISPLAY", ""}});
    EXPECT_EQ(outcome.code, 5);
    EXPECT_NE(outcome.err.find("`isocast render`"), std::string::npos) << outcome.err;
}

} // namespace
} // namespace isocast::test
