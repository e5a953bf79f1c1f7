// docs_buffers MOLECULE PICTURE: the images of a frame as in figure 7.5 of the thesis, on one
// sheet.
// SPDX-License-Identifier: MPL-2.0
#include "gl/context.h"
#include "quadrics/molecule_styles.h"
#include "raycaster/image_files.h"
#include "raycaster/renderer.h"

#include <fmt/format.h>

#include <functional>

namespace {

using namespace isocast;
using Colour = Eigen::Vector3f; // linear

constexpr int width = 300;
constexpr int height = 260;
constexpr int columns = 4;
const Colour nothing = Colour::Constant(0.7F); // light atoms show before it

/// Pictures of one size, four to a row.
class Sheet {
public:
    /// colour_at  of a pixel, x to the right and y downwards
    void add(const std::function<Colour(int x, int y)>& colour_at) {
        const int left = count_ % columns * width;
        const int top = count_++ / columns * height;
        if (count_ % columns == 1) {
            image_.height += height;
            image_.rgba.resize(4 * static_cast<std::size_t>(columns) * width *
                                   static_cast<std::size_t>(image_.height),
                               1);
        }
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                float* pixel = const_cast<float*>(image_.pixel(left + x, top + y));
                Eigen::Map<Colour>{pixel} = colour_at(x, y);
            }
    }
    const Image& image() const { return image_; }

private:
    Image image_{.width = columns * width, .height = 0, .rgba = {}};
    int count_ = 0;
};

Colour colour_of(const Image& image, int x, int y) {
    return Eigen::Map<const Colour>(image.pixel(x, y));
}

/// From black to white over the values of the pixels that show something.
void add_greys(Sheet& sheet, const Image& hits, const std::function<float(int, int)>& value) {
    float least = 1e30F;
    float greatest = -1e30F;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (hits.pixel(x, y)[3] == 0) continue;
            least = std::min(least, value(x, y));
            greatest = std::max(greatest, value(x, y));
        }
    sheet.add([&](int x, int y) -> Colour {
        if (hits.pixel(x, y)[3] == 0) return nothing;
        return Colour::Constant((value(x, y) - least) / (greatest - least));
    });
}

void draw_buffers(const std::filesystem::path& molecule, const std::filesystem::path& picture) {
    const MoleculePrimitives parts =
        primitives_of(read_molecule(molecule), {.ball_scale = 0.35, .stick_radius_angstrom = 0.22});
    const auto primitives = std::make_shared<Primitives>();
    primitives->spheres = parts.spheres;
    primitives->cylinders = parts.sticks;
    Scene scene{.primitives = primitives};
    scene.look.lights[0].direction = {-0.5, 0.7, 1};

    const auto context = gl::make_context();
    Renderer renderer(*context, std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders");
    renderer.load(scene);
    const Camera camera =
        frame_box(renderer.surface_points_world(), {1, 0.5, 1}, double(width) / height, 30);
    renderer.draw(camera, width, height, {FrameImage::Beauty});
    const Image phong = renderer.read(FrameImage::Beauty);
    scene.look.lights[0].shadow = Shadow::Soft;
    scene.look.lights[0].size_degrees = 6;
    scene.look.effects.outlines.strength = 1;
    renderer.load(scene);
    renderer.draw(camera, width, height, {FrameImage::Beauty, FrameImage::SplatColour});
    const auto read = [&](FrameImage image) { return renderer.read(image); };
    const Image hits = read(FrameImage::Hit);
    const Image colours = read(FrameImage::SplatColour);
    const Image normals = read(FrameImage::Gradient);
    const Image map = read(FrameImage::ShadowMap);
    const Image shadow = read(FrameImage::Shadow);
    const Image lines = read(FrameImage::Outlines);
    const Image beauty = read(FrameImage::Beauty);

    Sheet sheet;
    sheet.add([&](int x, int y) -> Colour {
        return hits.pixel(x, y)[3] == 0 ? nothing : colour_of(colours, x, y);
    });
    const Vec3d back = camera.view_from_world_rotation().row(2).transpose();
    add_greys(sheet, hits,
              [&](int x, int y) { return back.cast<float>().dot(colour_of(hits, x, y)); });
    sheet.add([&](int x, int y) -> Colour {
        if (hits.pixel(x, y)[3] == 0) return nothing;
        const Eigen::Matrix3f view = camera.view_from_world_rotation().cast<float>();
        return 0.5F * (view * colour_of(normals, x, y) + Colour::Ones());
    });
    sheet.add([&](int x, int y) { return colour_of(phong, x, y); });
    // The light's picture, as large as fits; how far below its plane, in texels.
    const float scale =
        static_cast<float>(std::max(double(map.width) / width, double(map.height) / height));
    const auto of_map = [&](int x, int y) -> float {
        const int u =
            static_cast<int>((static_cast<float>(x) - 0.5F * width) * scale) + map.width / 2;
        const int v =
            static_cast<int>((static_cast<float>(y) - 0.5F * height) * scale) + map.height / 2;
        const bool is_there = u >= 0 && u < map.width && v >= 0 && v < map.height;
        const float depth = is_there ? map.pixel(u, v)[0] : 1e30F;
        return depth < 1e6F ? depth : -1;
    };
    float deepest = 1;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) deepest = std::max(deepest, of_map(x, y));
    sheet.add([&](int x, int y) -> Colour {
        const float depth = of_map(x, y);
        return Colour::Constant(depth < 0 ? nothing.x() : 1 - depth / deepest);
    });
    sheet.add([&](int x, int y) -> Colour {
        return hits.pixel(x, y)[3] == 0 ? nothing : Colour::Constant(shadow.pixel(x, y)[0]);
    });
    sheet.add([&](int x, int y) -> Colour { return Colour::Constant(1 - lines.pixel(x, y)[3]); });
    sheet.add([&](int x, int y) { return colour_of(beauty, x, y); });
    write_png(sheet.image(), picture);
}

} // namespace

int main(int argc, char** argv) try {
    if (argc != 3) {
        fmt::print(stderr, "usage: docs_buffers MOLECULE PICTURE\n");
        return 2;
    }
    draw_buffers(argv[1], argv[2]);
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "docs_buffers: {}\n", error.what());
    return 1;
}
