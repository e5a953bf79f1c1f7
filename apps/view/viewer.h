// What is viewed and what is known of it, without window or panels.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/accuracy/promise.h"
#include "apps/sequence.h"
#include "apps/view/canvas.h"
#include "apps/view/comparing.h"
#include "apps/view/loading.h"
#include "raycaster/fetch_choice.h"
#include "volume/histogram.h"

#include <deque>
#include <memory>
#include <optional>

namespace isocast::view {

/// What there is at a point of a surface.
struct Probe {
    Vec3d p_world = Vec3d::Zero();
    /// Of the field: the iso value of what was hit; in a cut what the first object's field is
    /// there.
    double value_world = 0;
    double gradient = 0; // its length
    Vec3d normal = Vec3d::Zero();
    std::optional<std::array<double, 2>> curvature; // k1 >= k2 [1/world]
    Vec3d direction_1 = Vec3d::Zero();              // of k1, unit
    /// For people and for the clipboard.
    std::string text() const;
};

/// Draws until all is drawn that the user waits for.
class Viewer {
public:
    struct Options {
        std::vector<std::filesystem::path> data_folders; // for the front
        double target_milliseconds = 33;
        int samples = 4; // of a pixel, at rest
    };
    Viewer(gl::Context& context, const std::filesystem::path& shader_folder, Options options,
           std::function<void()> wake);

    // What the user does. Failures become messages, and what was there stays.
    void open(SceneFile scene);
    /// A scene takes the place of what there is; else one object more.
    void add_file(const std::filesystem::path& path);
    void cancel_loading();
    /// The cheapest filter and resolution that keep it, as of `isocast render --max-error`.
    void keep_error(double max_error_world);
    /// Draws the reference of this view, and then shows how far the picture is from it.
    void compare();
    /// The scene with something else; what it takes follows from the key's name, as in sequences.
    void change(SceneFile scene, const std::string& key);
    void set_camera(const Camera& camera);
    /// As `isocast render` frames it.
    void reset_camera();
    void frame(); // the same, from where the camera looks
    void set_pivot(const Vec3d& pivot_world) { pivot_world_ = pivot_world; }
    void resize(int width, int height);
    void save_scene(const std::filesystem::path& path);
    void save_picture(const std::filesystem::path& path);
    void show_steps(std::optional<int> most_steps);
    void set_samples(int samples);
    void set_target(double milliseconds) { options_.target_milliseconds = milliseconds; }
    void say(std::string message);

    /// Whether step() has something to do.
    bool is_busy() const;
    /// A little of what is to be done.
    ///
    /// pump     called now and then while a scene goes to the GPU; may throw Interrupted
    /// returns  what was drawn, if anything
    std::optional<Step> step(const std::function<void(std::string_view, double)>& pump);

    /// What is seen at a pixel of the canvas, from its top left corner; nothing beside surfaces.
    std::optional<Probe> probe(double x, double y);

    bool has_scene() const { return is_loaded_; }
    int load_count() const { return load_count_; }
    const SceneFile& scene() const { return scene_; }
    const Scene& loaded() const { return loaded_; }
    const Loading* loading() const { return loading_.get(); }
    const Comparing* comparing() const { return comparing_.get(); }
    /// Of the scene as it is, if it was chosen by its error.
    const std::optional<Promise>& promise() const { return promise_; }
    Canvas& canvas() { return canvas_; }
    const Camera& camera() const { return canvas_.camera(); }
    const Vec3d& pivot() const { return pivot_world_; }
    const Options& options() const { return options_; }
    const std::optional<Histogram>& histogram() const { return histogram_; }
    std::deque<std::string>& messages() { return messages_; }
    /// Of the last whole picture that was drawn, each part's added.
    const FrameReport& report() const { return report_; }
    double picture_milliseconds() const { return picture_milliseconds_; }
    const gl::DriverInfo& driver() const { return context_.driver(); }

private:
    void finish_comparing();
    void start(SceneFile scene, Loading::Prepare prepare);
    void finish_loading(const std::function<void(std::string_view, double)>& pump);
    /// May draw a probe, after which nothing is loaded.
    void choose_fetch_for(const SceneFile& file, Scene& scene);
    void load(Scene scene, const Progress& progress);
    void take_scene(SceneFile scene);
    SceneFile scene_as_seen() const;
    void count(const Step& step);

    gl::Context& context_;
    Renderer renderer_;
    Canvas canvas_;
    Options options_;
    std::function<void()> wake_;
    SceneObjects objects_;
    std::unique_ptr<Loading> loading_;
    std::unique_ptr<Comparing> comparing_;
    std::shared_ptr<Promise> promised_; // by what is loading
    std::optional<Promise> promise_;
    SceneFile asked_;               // that it loads
    std::optional<SceneFile> next_; // to be loaded once that is done
    SceneFile scene_;
    Scene loaded_;
    bool is_loaded_ = false;
    int load_count_ = 0;
    std::optional<FetchChoice> fetch_; // if the scene leaves it open
    std::optional<Filter> fetch_for_;
    Vec3d pivot_world_ = Vec3d::Zero();
    bool is_moving_ = true; // the next step draws coarsely
    std::optional<Histogram> histogram_;
    std::deque<std::string> messages_;
    FrameReport report_;
    FrameReport counted_; // of the round so far
    double picture_milliseconds_ = 0;
    double counted_milliseconds_ = 0;
};

} // namespace isocast::view
