// The keys of effects: those of raycaster/look.h.
// SPDX-License-Identifier: MPL-2.0
#include "apps/key_kinds.h"

namespace isocast {

namespace {

using namespace keys;
using Path = std::filesystem::path;

template<class Place>
SceneKey strength(Place place) {
    return number("strength", place, share,
                  "How much of it shows; a table that does not say has 1, and without a table "
                  "the effect does not exist");
}

std::array<double, 2> interval_of(const SceneValue& value) {
    const auto* list = std::get_if<std::vector<double>>(&value);
    if (!list || list->size() != 2 || !((*list)[0] < (*list)[1]))
        throw UsageError("expected two numbers [lo, hi], lo < hi");
    return {(*list)[0], (*list)[1]};
}

std::vector<SceneTable> surface_effects() {
    constexpr auto solid_texture = within(
        [](SceneFile & file, std::size_t) -> auto& { return file.look.effects.solid_texture; });
    constexpr auto curvature_colour = within(
        [](SceneFile & file, std::size_t) -> auto& { return file.look.effects.curvature_colour; });
    constexpr auto curvature_map = within(
        [](SceneFile & file, std::size_t) -> auto& { return file.look.effects.curvature_map; });
    constexpr auto look_files =
        within([](SceneFile& file, std::size_t) -> LookFiles& { return file.look_files; });
    constexpr auto uncertainty = within(
        [](SceneFile & file, std::size_t) -> auto& { return file.look.effects.uncertainty; });
    constexpr auto flow =
        within([](SceneFile& file, std::size_t) -> Flow& { return file.look.effects.flow; });
    constexpr auto accessibility = within(
        [](SceneFile & file, std::size_t) -> auto& { return file.look.effects.accessibility; });
    constexpr auto occlusion = within(
        [](SceneFile& file, std::size_t) -> Occlusion& { return file.look.effects.occlusion; });
    using Kind = SolidTexture::Kind;
    return {
        {"effects.solid_texture",
         "A texture in space.",
         {strength(solid_texture(&SolidTexture::strength)),
          choice("kind", solid_texture(&SolidTexture::kind),
                 Names<Kind>{{"checker", Kind::Checker},
                             {"stripes", Kind::Stripes},
                             {"marble", Kind::Marble},
                             {"wood", Kind::Wood},
                             {"volume", Kind::Volume}},
                 "What it looks like"),
          number("scale_world", solid_texture(&SolidTexture::scale_world), positive,
                 "One period (else a twelfth of the field's diagonal)"),
          vector("origin_world", solid_texture(&SolidTexture::origin_world),
                 "Where its coordinates are 0; wood's rings go round it"),
          direction("axis", solid_texture(&SolidTexture::axis),
                    "Across stripes and marble's veins, along wood's trunk"),
          colour("colour_a", solid_texture(&SolidTexture::colour_a), "One colour"),
          colour("colour_b", solid_texture(&SolidTexture::colour_b), "The other"),
          special(
              "volume", "file or field:NAME@N", "Of kind volume: 0 is colour_a, 1 colour_b",
              [](SceneFile& file, std::size_t, const SceneValue& value, const Path& folder) {
                  const std::string path = resolved(text_of(value), folder);
                  file.look.effects.solid_texture.volume = read_field(input_from(path));
                  file.look_files.texture_volume = path;
              },
              [](const SceneFile& file, std::size_t, const Path& folder) {
                  return path_value_of_read(file.look.effects.solid_texture.volume != nullptr,
                                            file.look_files.texture_volume, folder);
              }),
          choice("volume_filter", solid_texture(&SolidTexture::volume_filter),
                 Names<std::string>{{"bspline", "bspline"}, {"linear", "linear"}},
                 "How it is read")}},
        {"effects.curvature_colour",
         "One curvature measure through a map of colours.",
         {strength(curvature_colour(&CurvatureColour::strength)),
          choice("measure", curvature_colour(&CurvatureColour::measure),
                 Names<CurvatureMeasure>{{"k1", CurvatureMeasure::K1},
                                         {"k2", CurvatureMeasure::K2},
                                         {"mean", CurvatureMeasure::Mean},
                                         {"gauss", CurvatureMeasure::Gauss},
                                         {"shape_index", CurvatureMeasure::ShapeIndex},
                                         {"curvedness", CurvatureMeasure::Curvedness}},
                 "Which"),
          choice(
              "map", curvature_colour(&CurvatureColour::map),
              Names<ColourMap>{{"viridis", ColourMap::Viridis}, {"cool-warm", ColourMap::CoolWarm}},
              "Colours; unless said cool-warm for signed measures, viridis for curvedness"),
          key("range", "[lo, hi]",
              "What the ends of the map stand for [1/world; gauss 1/world^2]; else the "
              "picture's percentiles",
              curvature_colour(&CurvatureColour::range), interval_of)}},
        {"effects.curvature_map",
         "Both principal curvatures through a picture: k1 to the right, k2 upwards.",
         {strength(curvature_map(&CurvatureMap::strength)),
          picture("picture", curvature_map(&CurvatureMap::picture),
                  look_files(&LookFiles::curvature_map), "Else a built-in one"),
          number("range", curvature_map(&CurvatureMap::range), positive,
                 "The picture goes from -range to range [1/world]")}},
        {"effects.uncertainty",
         "Where a small change of the iso value moves the surface far.",
         {strength(uncertainty(&Uncertainty::strength)),
          number("range", uncertainty(&Uncertainty::range), positive,
                 "Flow-line curvature that is uncertain for certain [1/world]"),
          colour("colour", uncertainty(&Uncertainty::colour), "Of uncertain places")}},
        {"effects.flow",
         "Lines along a principal direction.",
         {strength(flow(&Flow::strength)),
          integer("direction", flow(&Flow::direction), {1, 2}, "Of k1 or k2"),
          number("length_pixels", flow(&Flow::length_pixels), positive, "Of a line"),
          number("grain_pixels", flow(&Flow::grain_pixels), positive, "Its width"),
          number("phase", flow(&Flow::phase), share, "For animations, in 0 ... 1: lines travel")}},
        {"effects.accessibility",
         "Hollows are darker, by k2.",
         {strength(accessibility(&Accessibility::strength)),
          number("radius_world", accessibility(&Accessibility::radius_world), positive,
                 "Of a hollow that is black")}},
        {"effects.occlusion",
         "Ambient light that fields and primitives keep away from themselves and from each other.",
         {strength(occlusion(&Occlusion::strength)),
          number("distance_world", occlusion(&Occlusion::distance_world), positive,
                 "How far occluders count; else a tenth of the diagonal of all that is drawn"),
          integer("rays", occlusion(&Occlusion::rays), {1, 1024}, "For each pixel")}},
    };
}

std::vector<SceneTable> overlay_effects() {
    constexpr auto refraction = within(
        [](SceneFile& file, std::size_t) -> Refraction& { return file.look.effects.refraction; });
    constexpr auto reflection = within(
        [](SceneFile& file, std::size_t) -> Reflection& { return file.look.effects.reflection; });
    constexpr auto ridges =
        within([](SceneFile& file, std::size_t) -> Ridges& { return file.look.effects.ridges; });
    constexpr auto contours = within(
        [](SceneFile& file, std::size_t) -> Contours& { return file.look.effects.contours; });
    constexpr auto outlines = within(
        [](SceneFile& file, std::size_t) -> Outlines& { return file.look.effects.outlines; });
    constexpr auto slice =
        within([](SceneFile& file, std::size_t) -> Slice& { return file.look.effects.slice; });
    return {
        {"effects.refraction",
         "The environment, seen through the object.",
         {strength(refraction(&Refraction::strength)),
          number("index", refraction(&Refraction::index), {1, 10}, "Of refraction")}},
        {"effects.reflection",
         "The environment, mirrored.",
         {strength(reflection(&Reflection::strength)),
          truth("has_fresnel", reflection(&Reflection::has_fresnel),
                "Stronger at grazing angles, by the index of refraction")}},
        {"effects.ridges",
         "Lines along ridges and valleys.",
         {strength(ridges(&Ridges::strength)),
          number("threshold", ridges(&Ridges::threshold), positive,
                 "Curvature of a line [1/world]; else by the picture's percentiles"),
          colour("ridge_colour", ridges(&Ridges::ridge_colour), "Of ridges"),
          colour("valley_colour", ridges(&Ridges::valley_colour), "Of valleys")}},
        {"effects.contours",
         "Contours of even thickness, by the curvature along the view.",
         {strength(contours(&Contours::strength)),
          number("thickness_pixels", contours(&Contours::thickness_pixels), positive,
                 "Their width"),
          colour("colour", contours(&Contours::colour), "Their colour")}},
        {"effects.outlines",
         "Edges of depths and normals in the picture.",
         {strength(outlines(&Outlines::strength)),
          number("silhouette_threshold", outlines(&Outlines::silhouette_threshold), positive,
                 "Of depth, relative to the object's size"),
          number("crease_threshold", outlines(&Outlines::crease_threshold), positive, "Of normals"),
          colour("colour", outlines(&Outlines::colour), "Of lines")}},
        {"effects.slice",
         "A plane that shows the field of the first object itself, over all that lies behind it.",
         {strength(slice(&Slice::strength)),
          direction("normal", slice(&Slice::normal), "Of the plane"),
          number("offset", slice(&Slice::offset_world), {},
                 "How far along the normal the plane is from the world's origin [world]"),
          number("spacing", slice(&Slice::spacing_world), positive,
                 "Lines where the field is a multiple of it; else about 1/50 of its diagonal, or a "
                 "third of its band"),
          number("range", slice(&Slice::range_world), positive,
                 "So far from the iso value tones are full; else the band's half width, or ten "
                 "lines"),
          colour("inside", slice(&Slice::inside), "Below the iso value"),
          colour("outside", slice(&Slice::outside), "Above it"),
          colour("line", slice(&Slice::line), "Of lines; that of the iso value is thick")}},
    };
}

} // namespace

std::vector<SceneTable> effect_tables() {
    std::vector<SceneTable> tables = surface_effects();
    for (SceneTable& table : overlay_effects()) tables.push_back(std::move(table));
    return tables;
}

} // namespace isocast
