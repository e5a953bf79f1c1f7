// What the panels show of a scene: its objects, effects, lights and cuts.
// SPDX-License-Identifier: MPL-2.0
#include "apps/view/panels.h"
#include "raycaster/effects/colour_maps.h"
#include "raycaster/effects/effects.h"
#include "raycaster/image.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <imgui.h>

#include <algorithm>

namespace isocast::view {

namespace {

std::string words(std::string text) {
    std::ranges::replace(text, '_', ' ');
    return text;
}

/// What it is, and what for.
std::string role_of(const SceneFile& scene, std::size_t i) {
    const SceneObject& object = scene.objects[i];
    using Csg = SceneObject::Csg;
    std::string role = object.csg ? fmt::format("{} of {}",
                                                *object.csg == Csg::Union          ? "union"
                                                : *object.csg == Csg::Intersection ? "intersection"
                                                                                   : "difference",
                                                fmt::join(object.of, ", "))
                       : !object.morph.empty()
                           ? fmt::format("morph of {}", fmt::join(object.morph, ", "))
                       : !object.mesh.empty()       ? "mesh"
                       : !object.molecule.empty()   ? "molecule"
                       : !object.points.empty()     ? "points"
                       : !object.tetrahedra.empty() ? "tetrahedra"
                       : !object.slim.empty()       ? "SLIM surface"
                       : !object.series.empty()     ? "series"
                                                    : "field";
    std::vector<std::string> users;
    for (const std::size_t k : users_of(scene, i)) users.push_back(name_of(scene, k));
    if (!users.empty()) role += fmt::format(", in {}", fmt::join(users, ", "));
    return role;
}

ImU32 on_screen(const Vec3d& linear) {
    const auto byte = [](double c) {
        return static_cast<int>(255 * srgb_encoded(static_cast<float>(std::clamp(c, 0.0, 1.0))) +
                                0.5F);
    };
    return IM_COL32(byte(linear.x()), byte(linear.y()), byte(linear.z()), 255);
}

/// A bar from `lo` to `hi` in the colours of `at`, for 0 to 1.
void legend(const std::string& lo, const std::string& hi, float height,
            const std::function<Vec3d(double)>& at) {
    const ImVec2 begin = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x;
    constexpr int parts = 64;
    const auto x = [&](int i) { return begin.x + width * static_cast<float>(i) / parts; };
    for (int i = 0; i < parts; ++i)
        ImGui::GetWindowDrawList()->AddRectFilled({x(i), begin.y}, {x(i + 1), begin.y + height},
                                                  on_screen(at((i + 0.5) / parts)));
    ImGui::Dummy({width, height});
    ImGui::TextUnformatted(lo.c_str());
    ImGui::SameLine(
        std::max(0.0F, ImGui::GetCursorPosX() + width - ImGui::CalcTextSize(hi.c_str()).x));
    ImGui::TextUnformatted(hi.c_str());
}

} // namespace

const SceneTable& Panels::table(std::string_view name) const {
    return *std::ranges::find(tables_, name, &SceneTable::name);
}

std::string Panels::price(std::initializer_list<std::string_view> passes) const {
    double sum = 0;
    bool ran = false;
    for (const PassReport& pass : viewer_.report().passes)
        if (pass.ran && std::ranges::find(passes, pass.name) != passes.end()) {
            sum += pass.milliseconds;
            ran = true;
        }
    return ran ? fmt::format("{:.1f} ms", sum) : "";
}

void Panels::draw_histogram() {
    const SceneTable& objects = table("object");
    const Histogram& histogram = *viewer_.histogram();
    std::vector<float> counts(histogram.counts.begin(), histogram.counts.end());
    // The greatest peak would hide the rest.
    for (float& count : counts) count = std::sqrt(count);
    const ImVec2 size(ImGui::GetContentRegionAvail().x, 60 * scale_);
    ImGui::PlotHistogram("##histogram", counts.data(), static_cast<int>(counts.size()), 0,
                         "values, root of their number", 0, FLT_MAX, size);
    mark("histogram");
    double iso = viewer_.loaded().objects.front().iso_world;
    const double lo = histogram.edge(0);
    const double hi = histogram.edge(counts.size());
    const ImVec2 min = ImGui::GetItemRectMin();
    const ImVec2 max = ImGui::GetItemRectMax();
    const auto x = static_cast<float>(min.x + (iso - lo) / (hi - lo) * (max.x - min.x));
    ImGui::GetWindowDrawList()->AddLine({x, min.y}, {x, max.y}, IM_COL32(255, 160, 0, 255),
                                        2 * scale_);
    ImGui::SetNextItemWidth(-40 * scale_);
    const double asked = iso;
    ImGui::SliderScalar("iso", ImGuiDataType_Double, &iso, &lo, &hi, "%.4g");
    mark("iso");
    if (iso != asked) set(objects, 0, *objects.key("iso"), iso);
}

void Panels::draw_objects() {
    if (!header("Objects", true)) return;
    const SceneTable& objects = table("object");
    for (std::size_t i = 0; i < viewer_.scene().objects.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        if (i == 0 && viewer_.histogram() && !viewer_.loaded().objects.empty()) draw_histogram();
        // What combines it decides whether an operand is seen.
        if (users_of(viewer_.scene(), i).empty()) {
            bool is_shown = viewer_.scene().objects[i].is_shown;
            if (ImGui::Checkbox("##shown", &is_shown))
                set(objects, i, *objects.key("shown"), is_shown);
            mark(fmt::format("shown {}", i));
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("shown");
            ImGui::SameLine();
        }
        const bool is_open = ImGui::TreeNode("keys", "%s", name_of(viewer_.scene(), i).c_str());
        mark(fmt::format("object {}", i));
        ImGui::SameLine();
        ImGui::TextDisabled("%s", role_of(viewer_.scene(), i).c_str());
        if (const SceneObject& object = viewer_.scene().objects[i];
            !object.molecule.empty() && !object.surface && !is_open) {
            ImGui::PushItemWidth(ImGui::GetContentRegionAvail().x * 0.5F);
            draw_key(objects, i, *objects.key("style"));
            draw_key(objects, i, *objects.key("colours"));
            ImGui::PopItemWidth();
        }
        if (is_open) {
            draw_keys(objects, i);
            if (viewer_.scene().objects.size() > 1 && ImGui::Button("Remove")) {
                SceneFile scene = viewer_.scene();
                scene.objects.erase(scene.objects.begin() + static_cast<std::ptrdiff_t>(i));
                viewer_.open(std::move(scene));
            }
            ImGui::TreePop();
        }
        ImGui::PopID();
    }
}

void Panels::draw_legends(const SceneTable& effect) {
    const Effects& effects = viewer_.scene().look.effects;
    if (effect.name == "effects.curvature_colour" && effects.curvature_colour.strength > 0) {
        const CurvatureColour& colour = effects.curvature_colour;
        for (const std::string& note : viewer_.report().notes)
            if (note.starts_with("curvature colour: ")) found_range_ = note.substr(18);
        const auto at = [&](double t) {
            return colour_of(colour.map.value_or(default_colour_map(colour.measure)), t);
        };
        if (colour.range)
            legend(fmt::format("{:.4g}", (*colour.range)[0]),
                   fmt::format("{:.4g}", (*colour.range)[1]), 12 * scale_, at);
        else
            legend(found_range_, "", 12 * scale_, at);
        mark("legend of curvature colour");
    }
    if (effect.name == "effects.slice" && effects.slice.strength > 0 &&
        !viewer_.loaded().objects.empty()) {
        const Slice& slice = effects.slice;
        const FieldObject& object = viewer_.loaded().objects.front();
        const double range = slice_range_world(slice, *object.field);
        legend(fmt::format("{:.4g}", object.iso_world - range),
               fmt::format("{:.4g}", object.iso_world + range), 12 * scale_, [&](double t) {
                   const double u = 2 * t - 1;
                   return Vec3d((1 - std::abs(u)) * slice_paper() +
                                std::abs(u) * (u < 0 ? slice.inside : slice.outside));
               });
        mark("legend of slice");
        ImGui::TextDisabled("lines every %.4g", slice_spacing_world(slice, *object.field));
    }
}

void Panels::draw_effects() {
    if (!header("Effects", false)) return;
    for (const SceneTable& one : tables_) {
        if (!one.name.starts_with("effects.")) continue;
        for (const auto& [first, title] :
             {std::pair{"solid_texture", "colours"}, std::pair{"accessibility", "light"},
              std::pair{"ridges", "lines"}, std::pair{"slice", "the field itself"}})
            if (one.name.substr(8) == first) ImGui::TextDisabled("%s", title);
        const std::string name = words(one.name.substr(8));
        ImGui::PushID(one.name.c_str());
        const bool is_open = ImGui::TreeNode("effect", "%s", name.c_str());
        mark(name);
        if (const std::string cost = price({name}); !cost.empty()) {
            ImGui::SameLine(ImGui::GetWindowContentRegionMax().x -
                            ImGui::CalcTextSize(cost.c_str()).x);
            ImGui::TextDisabled("%s", cost.c_str());
        }
        draw_legends(one);
        if (is_open) {
            draw_keys(one, 0);
            ImGui::TreePop();
        }
        ImGui::PopID();
    }
}

void Panels::draw_elements(const SceneTable& elements, const char* name, std::size_t most) {
    const std::size_t count = elements.count(viewer_.scene());
    for (std::size_t i = 0; i < count; ++i)
        if (ImGui::TreeNodeEx(reinterpret_cast<void*>(i + 1), ImGuiTreeNodeFlags_DefaultOpen,
                              "%s %d", name, static_cast<int>(i + 1))) {
            draw_keys(elements, i);
            ImGui::TreePop();
        }
    const auto resize = [&](std::size_t size) {
        SceneFile scene = viewer_.scene();
        elements.resize(scene, size);
        viewer_.change(std::move(scene), elements.name + ".0");
    };
    if (count < most) {
        if (ImGui::Button("One more")) resize(count + 1);
        mark(fmt::format("one more {}", name));
    }
    if (count > 0) {
        ImGui::SameLine();
        if (ImGui::Button("One less")) resize(count - 1);
        mark(fmt::format("one less {}", name));
    }
}

void Panels::draw_lights() {
    if (!header("Lights", false)) return;
    ImGui::PushID("lights");
    if (const std::string cost = price({"shadow map", "shadow"}); !cost.empty())
        ImGui::TextDisabled("shadows %s", cost.c_str());
    draw_elements(table("light"), "light", max_light_count);
    ImGui::PopID();
}

void Panels::draw_cuts() {
    if (!header("Cuts", false)) return;
    ImGui::PushID("cuts");
    if (std::ranges::any_of(viewer_.scene().objects, is_of_primitives)) draw_keys(table("cut"), 0);
    draw_elements(table("cut.plane"), "plane", max_cut_planes);
    ImGui::PopID();
}

} // namespace isocast::view
