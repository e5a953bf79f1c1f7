// SPDX-License-Identifier: MPL-2.0
#include "apps/view/panels.h"

#include "apps/view/key_widgets.h"
#include "volume/atomic_file.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <fstream>

namespace isocast::view {

namespace {

constexpr std::size_t most_recent = 8;

struct KeyHelp {
    const char* key;
    const char* what;
};
constexpr std::array help{
    KeyHelp{"left drag", "rotate about the pivot"},
    KeyHelp{"middle drag, Shift + left drag", "pan"},
    KeyHelp{"wheel, right drag", "zoom towards the cursor"},
    KeyHelp{"Ctrl + left drag", "roll"},
    KeyHelp{"double click", "pivot on the surface under the cursor"},
    KeyHelp{"click", "pin the probe, while its panel is open"},
    KeyHelp{"R", "reset the camera"},
    KeyHelp{"F", "frame the object from here"},
    KeyHelp{"1  3  7", "view along z, x, y; with Ctrl from behind"},
    KeyHelp{"O", "perspective or orthographic"},
    KeyHelp{"S", "screenshot: isocast-N.png"},
    KeyHelp{"Ctrl + S", "save the scene: isocast-N.toml"},
    KeyHelp{"H", "hide or show the panels"},
    KeyHelp{"?", "this list"},
};

/// On the canvas, in pixels from its top left corner; nothing behind the eye.
std::optional<Eigen::Vector2d> seen_at(const Camera& camera, int width, int height,
                                       const Vec3d& p_world) {
    const Vec3d p = camera.view_from_world_rotation() * (p_world - camera.eye_world);
    const bool is_perspective = camera.projection == Projection::Perspective;
    if (is_perspective && p.z() >= 0) return std::nullopt;
    const double pixels = height / (2 * camera.half_height_at(is_perspective ? -p.z() : 1));
    return Eigen::Vector2d(width / 2.0 + pixels * p.x(), height / 2.0 - pixels * p.y());
}

} // namespace

Panels::Panels(Viewer& viewer, float scale, const std::filesystem::path& config_folder)
    : viewer_(viewer), scale_(scale),
      recent_path_(config_folder.empty() ? std::filesystem::path() : config_folder / "recent.txt") {
    std::ifstream file(recent_path_);
    for (std::string line; std::getline(file, line);) recent_.push_back(line);
}

void Panels::remember(const std::filesystem::path& file) {
    const std::string name = std::filesystem::absolute(file).string();
    std::erase(recent_, name);
    recent_.insert(recent_.begin(), name);
    if (recent_.size() > most_recent) recent_.resize(most_recent);
    if (recent_path_.empty()) return; // nobody's
    std::string text;
    for (const std::string& line : recent_) text += line + "\n";
    try {
        std::filesystem::create_directories(recent_path_.parent_path());
        write_text_file(text, recent_path_);
    } catch (const std::exception&) { // a list of recent files is worth no message
    }
}

Eigen::Vector2f Panels::margins() const {
    // The status line is as high as a line of widgets.
    return is_shown_ ? Eigen::Vector2f(340 * scale_, std::round(20 * scale_))
                     : Eigen::Vector2f(0, 0);
}

void Panels::pin(const Probe& probe) {
    // Two are measured between; a third begins anew.
    if (pins_.size() == 2) pins_.clear();
    pins_.push_back(probe);
}

void Panels::mark(const std::string& name) {
    const ImVec2 lo = ImGui::GetItemRectMin();
    const ImVec2 hi = ImGui::GetItemRectMax();
    places_[name] = {lo.x, lo.y, hi.x, hi.y};
}

bool Panels::header(const char* name, bool is_open) {
    const bool shows = ImGui::CollapsingHeader(name, is_open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
    mark(name);
    return shows;
}

void Panels::set(const SceneTable& table, std::size_t i, const SceneKey& key,
                 const SceneValue& value) {
    change(table, i, key,
           [&](SceneFile& scene) { key.set(scene, i, value, std::filesystem::current_path()); });
}

void Panels::change(const SceneTable& table, std::size_t i, const SceneKey& key,
                    const std::function<void(SceneFile&)>& by) {
    SceneFile scene = viewer_.scene();
    try {
        by(scene);
    } catch (const std::exception& error) {
        viewer_.say(fmt::format("{}.{}: {}", table.name, key.name, error.what()));
        return;
    }
    const std::string name = table.is_array() ? fmt::format("{}.{}.{}", table.name, i, key.name)
                                              : table.name + "." + key.name;
    viewer_.change(std::move(scene), name);
}

void Panels::draw_key(const SceneTable& table, std::size_t i, const SceneKey& key) {
    const std::string full = fmt::format("{}.{}.{}", table.name, i, key.name);
    const std::optional<SceneValue> value =
        key.get(viewer_.scene(), i, std::filesystem::current_path());
    const bool is_at_once =
        change_of_key(table.is_array() ? full : table.name + "." + key.name) != Change::Load;
    ImGui::PushID(full.c_str());
    const auto changed = key_widget(key, value, is_at_once, texts_[full]);
    mark(full);
    if (ImGui::IsItemHovered())
        ImGui::SetTooltip("%s\n%s%s", key.help.c_str(), key.type.c_str(),
                          key.reset ? "\nright click: as usual" : "");
    const bool is_reset =
        key.reset && ImGui::IsItemHovered() && ImGui::IsMouseClicked(ImGuiMouseButton_Right);
    if (is_reset) texts_[full].clear();
    ImGui::PopID();
    if (is_reset)
        change(table, i, key, [&](SceneFile& scene) { key.reset(scene, i); });
    else if (changed)
        set(table, i, key, *changed);
}

void Panels::draw_keys(const SceneTable& table, std::size_t i) {
    ImGui::PushItemWidth(ImGui::GetContentRegionAvail().x * 0.5F);
    for (const SceneKey& key : table.keys) draw_key(table, i, key);
    ImGui::PopItemWidth();
}

void Panels::draw_files() {
    if (!header("File", false)) return;
    ImGui::SetNextItemWidth(-1);
    ImGui::InputTextWithHint("##path", "a file, or field:NAME@N, mesh:NAME", &path_);
    mark("path");
    if (ImGui::Button("Add")) {
        viewer_.add_file(path_);
        remember(path_);
    }
    mark("add");
    ImGui::SameLine();
    if (ImGui::Button("Save scene") && path_.ends_with(".toml")) viewer_.save_scene(path_);
    mark("save scene");
    ImGui::SameLine();
    if (ImGui::Button("Save picture") && !path_.empty()) viewer_.save_picture(path_);
    mark("save picture");
    for (const std::string& name : recent_)
        if (ImGui::Selectable(std::filesystem::path(name).filename().string().c_str()))
            viewer_.add_file(name);
    ImGui::TextDisabled("Files can be dropped on the window, too.");
}

void Panels::draw_cost() {
    if (!header("What accuracy costs", false)) return;
    if (!viewer_.loaded().objects.empty()) {
        const double voxel = viewer_.loaded().objects.front().field->space().voxel_size_world();
        const double lo = 1e-3;
        const double hi = 2;
        ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * 0.5F);
        ImGui::SliderScalar("error [voxels]", ImGuiDataType_Double, &max_error_voxels_, &lo, &hi,
                            "%.3g", ImGuiSliderFlags_Logarithmic);
        mark("error");
        if (ImGui::IsItemDeactivatedAfterEdit()) viewer_.keep_error(max_error_voxels_ * voxel);
        if (const auto& promise = viewer_.promise())
            ImGui::TextWrapped("%s%s promises %.2g, for %.0f ms",
                               std::string(filter_name(promise->filter)).c_str(),
                               promise->resolution
                                   ? fmt::format(" at {} voxels", *promise->resolution).c_str()
                                   : "",
                               promise->error_world, 1000 * promise->seconds);
    }
    if (viewer_.comparing() != nullptr)
        ImGui::ProgressBar(static_cast<float>(viewer_.comparing()->work.state().fraction));
    else if (ImGui::Button("Difference from the reference"))
        viewer_.compare();
    mark("compare");
    int samples = 0;
    while (1 << samples < viewer_.options().samples) ++samples;
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * 0.5F);
    if (ImGui::SliderInt("rays a pixel", &samples, 0, 6, fmt::format("{}", 1 << samples).c_str()))
        viewer_.set_samples(1 << samples);
    auto target = static_cast<float>(viewer_.options().target_milliseconds);
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * 0.5F);
    if (ImGui::SliderFloat("ms a frame, moving", &target, 5, 200, "%.0f"))
        viewer_.set_target(target);
    bool shows_steps = viewer_.canvas().shows_steps();
    if (ImGui::Checkbox("looks at the field, each ray", &shows_steps))
        viewer_.show_steps(shows_steps ? std::optional(most_steps_) : std::nullopt);
    mark("steps");
    if (shows_steps) ImGui::Text("blue: none, red: %d and more", most_steps_);
    double sum = 0;
    for (const PassReport& pass : viewer_.report().passes) sum += pass.ran ? pass.milliseconds : 0;
    ImGui::Text("the last whole picture: %.0f ms", viewer_.picture_milliseconds());
    for (const PassReport& pass : viewer_.report().passes)
        if (pass.ran && pass.milliseconds > 0.005 * sum) {
            ImGui::ProgressBar(static_cast<float>(pass.milliseconds / sum),
                               ImVec2(ImGui::GetContentRegionAvail().x * 0.5F, 0),
                               fmt::format("{:.1f} ms", pass.milliseconds).c_str());
            ImGui::SameLine();
            ImGui::TextUnformatted(pass.name.c_str());
        }
    draw_keys(table("quality"), 0);
}

void Panels::draw_probe() {
    is_probing_ = header("Probe", false);
    if (!is_probing_) return;
    if (probe_)
        ImGui::TextUnformatted(probe_->text().c_str());
    else
        ImGui::TextDisabled("nothing under the cursor");
    for (std::size_t i = 0; i < pins_.size(); ++i) {
        ImGui::Separator();
        ImGui::Text("pin %d", static_cast<int>(i + 1));
        ImGui::TextUnformatted(pins_[i].text().c_str());
    }
    if (pins_.size() == 2)
        ImGui::Text("distance %.6g", (pins_[1].p_world - pins_[0].p_world).norm());
    if (pins_.empty()) return;
    if (ImGui::Button("Copy")) {
        std::string text;
        for (const Probe& pin : pins_) text += pin.text() + "\n\n";
        ImGui::SetClipboardText(text.c_str());
    }
    mark("copy");
    ImGui::SameLine();
    if (ImGui::Button("Clear")) pins_.clear();
}

void Panels::draw_marks(double pixels_per_unit) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    Canvas& canvas = viewer_.canvas();
    const auto at = [&](const Vec3d& p_world) -> std::optional<ImVec2> {
        const auto p = seen_at(canvas.camera(), canvas.width(), canvas.height(), p_world);
        if (!p) return std::nullopt;
        return ImVec2(margins().x() + static_cast<float>(p->x() / pixels_per_unit),
                      static_cast<float>(p->y() / pixels_per_unit));
    };
    const auto line = [&](const Vec3d& from, const Vec3d& to, ImU32 colour) {
        const auto a = at(from);
        const auto b = at(to);
        if (a && b) list.AddLine(*a, *b, colour, 2 * scale_);
    };
    const auto cross = [&](const Probe& probe) {
        const Camera& camera = canvas.camera();
        const double depth = (probe.p_world - camera.eye_world).norm();
        const double arm = 0.04 * camera.half_height_at(depth);
        if (probe.curvature) {
            const Vec3d other = probe.normal.cross(probe.direction_1);
            line(probe.p_world - arm * probe.direction_1, probe.p_world + arm * probe.direction_1,
                 IM_COL32(220, 60, 40, 255));
            line(probe.p_world - arm * other, probe.p_world + arm * other,
                 IM_COL32(40, 90, 220, 255));
        }
        line(probe.p_world, probe.p_world + arm * probe.normal, IM_COL32(30, 150, 60, 255));
    };
    if (is_probing_ && probe_) cross(*probe_);
    for (const Probe& pin : pins_) cross(pin);
    if (pins_.size() == 2) line(pins_[0].p_world, pins_[1].p_world, IM_COL32(30, 30, 30, 255));
}

void Panels::draw_status() {
    const ImGuiIO& io = ImGui::GetIO();
    const float height = margins().y();
    ImGui::SetNextWindowPos({0, io.DisplaySize.y - height});
    ImGui::SetNextWindowSize({io.DisplaySize.x, height});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(8 * scale_, 2 * scale_));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1, 1));
    ImGui::Begin("status", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoInputs);
    const Canvas& canvas = viewer_.canvas();
    const int rounds = canvas.complete_rounds();
    ImGui::Text("%d x %d   %s   %s   ? for keys", canvas.width(), canvas.height(),
                rounds == 0 ? "coarse"
                : canvas.is_complete(viewer_.options().samples)
                    ? fmt::format("{} rays a pixel", viewer_.options().samples).c_str()
                    : fmt::format("{} of {} rays a pixel",
                                  std::min(rounds, viewer_.options().samples - 1),
                                  viewer_.options().samples)
                          .c_str(),
                viewer_.driver().renderer.c_str());
    ImGui::End();
    ImGui::PopStyleVar(2);
}

void Panels::draw_help() {
    if (!has_help_) return;
    const ImGuiIO& io = ImGui::GetIO();
    ImGui::SetNextWindowPos({io.DisplaySize.x / 2, io.DisplaySize.y / 2}, ImGuiCond_Always,
                            {0.5F, 0.5F});
    ImGui::Begin("Keys", &has_help_,
                 ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoCollapse);
    if (ImGui::BeginTable("keys", 2)) {
        for (const auto& [key, what] : help) {
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(key);
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(what);
        }
        ImGui::EndTable();
    }
    ImGui::End();
}

void Panels::draw_messages() {
    if (viewer_.messages().empty()) return;
    const ImGuiIO& io = ImGui::GetIO();
    const float width = 420 * scale_;
    ImGui::SetNextWindowPos({io.DisplaySize.x - 10 * scale_, 10 * scale_}, ImGuiCond_Always,
                            {1, 0});
    ImGui::SetNextWindowSizeConstraints({width, 0}, {width, io.DisplaySize.y / 2});
    ImGui::Begin("Messages", nullptr,
                 ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoCollapse |
                     ImGuiWindowFlags_NoMove);
    for (const std::string& message : viewer_.messages()) {
        ImGui::TextWrapped("%s", message.c_str());
        ImGui::Separator();
    }
    if (ImGui::Button("Close")) viewer_.messages().clear();
    mark("close messages");
    ImGui::End();
}

void Panels::draw_loading() {
    const Loading* loading = viewer_.loading();
    if (loading == nullptr) return;
    const ImGuiIO& io = ImGui::GetIO();
    ImGui::SetNextWindowPos({io.DisplaySize.x / 2, io.DisplaySize.y - 90 * scale_},
                            ImGuiCond_Always, {0.5F, 0.5F});
    ImGui::SetNextWindowSize({360 * scale_, 0});
    ImGui::Begin("Loading", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoSavedSettings);
    const Work::State state = loading->work.state();
    ImGui::TextUnformatted(state.stage.c_str());
    ImGui::ProgressBar(static_cast<float>(state.fraction), ImVec2(-70 * scale_, 0));
    ImGui::SameLine();
    if (ImGui::Button("Cancel")) viewer_.cancel_loading();
    mark("cancel");
    ImGui::End();
}

void Panels::draw(double pixels_per_unit) {
    places_.clear();
    const ImGuiIO& io = ImGui::GetIO();
    draw_marks(pixels_per_unit);
    if (is_shown_) {
        ImGui::SetNextWindowPos({0, 0});
        ImGui::SetNextWindowSize({margins().x(), io.DisplaySize.y - margins().y()});
        ImGui::Begin("panels", nullptr,
                     ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                         ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
        draw_files();
        draw_objects();
        if (header("Shading", false)) {
            ImGui::TextDisabled("%s", price({"shading", "direct shading"}).c_str());
            draw_keys(table("shading"), 0);
        }
        draw_effects();
        draw_lights();
        draw_cuts();
        draw_cost();
        draw_probe();
        ImGui::End();
        draw_status();
    } else {
        is_probing_ = false;
    }
    draw_messages();
    draw_loading();
    draw_help();
}

} // namespace isocast::view
