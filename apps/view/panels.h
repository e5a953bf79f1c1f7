// The viewer's panels: what the user sees of a scene's keys, of costs and of points.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/scene_keys.h"
#include "apps/view/viewer.h"

namespace isocast::view {

/// Everything that is drawn over the canvas, by Dear ImGui.
class Panels {
public:
    /// scale  of letters and lines: 1 on a screen of 96 dots an inch
    Panels(Viewer& viewer, float scale, const std::filesystem::path& config_folder);

    /// Within a frame of ImGui.
    ///
    /// pixels_per_unit  of the canvas, by ImGui's units
    void draw(double pixels_per_unit);

    void toggle() { is_shown_ = !is_shown_; }
    /// What they take of the window, on the left and at the bottom [ImGui's units].
    Eigen::Vector2f margins() const;
    void toggle_help() { has_help_ = !has_help_; }
    /// What is under the cursor, shown until it is another; and pinned, if it was clicked.
    void set_probe(std::optional<Probe> probe) { probe_ = std::move(probe); }
    bool is_probing() const { return is_probing_; }
    void pin(const Probe& probe);
    void remember(const std::filesystem::path& file);

    /// Where some controls are: left, top, right, bottom, in ImGui's units; for --trace.
    const std::map<std::string, std::array<float, 4>>& places() const { return places_; }

private:
    bool header(const char* name, bool is_open);
    void mark(const std::string& name);
    void draw_files();
    void draw_objects();
    void draw_effects();
    void draw_legends(const SceneTable& effect);
    void draw_lights();
    void draw_cuts();
    void draw_cost();
    void draw_probe();
    void draw_status();
    void draw_help();
    void draw_messages();
    void draw_loading();
    void draw_marks(double pixels_per_unit);
    /// Widgets of all keys of a table's element.
    void draw_keys(const SceneTable& table, std::size_t i);
    void draw_key(const SceneTable& table, std::size_t i, const SceneKey& key);
    const SceneTable& table(std::string_view name) const;
    /// "12.3 ms", of passes by name.
    std::string price(std::initializer_list<std::string_view> passes) const;
    void set(const SceneTable& table, std::size_t i, const SceneKey& key, const SceneValue& value);
    void change(const SceneTable& table, std::size_t i, const SceneKey& key,
                const std::function<void(SceneFile&)>& by);
    /// The elements of a table of several, with buttons for one more and one less.
    void draw_elements(const SceneTable& table, const char* name, std::size_t most);
    void draw_histogram();

    Viewer& viewer_;
    float scale_;
    std::filesystem::path recent_path_;
    std::vector<std::string> recent_;
    std::vector<SceneTable> tables_ = scene_tables();
    bool is_shown_ = true;
    bool has_help_ = false;
    bool is_probing_ = true;
    int most_steps_ = 64;
    double max_error_voxels_ = 0.1; // that is asked for
    std::optional<Probe> probe_;
    std::vector<Probe> pins_; // that were clicked: two at most
    std::map<std::string, std::array<float, 4>> places_;
    std::map<std::string, std::string> texts_; // that are being typed, by key
    std::string path_;
    std::string found_range_; // of curvature colours, in words
};

} // namespace isocast::view
