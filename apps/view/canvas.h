// The picture in the window: coarse while something moves, whole when it rests, then smoother.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/view/pace.h"

#include <optional>

namespace isocast::view {

/// What one step drew.
struct Step {
    bool is_coarse = false;
    PicturePart part; // of a picture of width x height
    int width = 0;
    int height = 0;
    int round = 0;           // each is a sample more of every pixel, from 0
    bool ends_round = false; // it was the last part of the round
    double milliseconds = 0; // by the clock
    FrameReport report = {};
};

/// Every program that a canvas can ask for.
std::vector<gl::ProgramKey> canvas_programs();

/// Draws what a renderer has loaded, step by step; each leaves room for the user's input.
class Canvas {
public:
    /// renderer       must outlive this, which decides what parts it keeps
    /// shader_folder  the project's shaders/
    Canvas(Renderer& renderer, const std::filesystem::path& shader_folder);

    /// In pixels of the window's framebuffer; what was drawn is lost.
    void resize(int width, int height);
    int width() const { return image_.width(); }
    int height() const { return image_.height(); }

    /// Hits are others: all is drawn again. What is on the canvas stays until then.
    void restart(const Camera& camera);
    /// Another look, of the same hits: the first round takes those that are kept.
    /// throws  as Renderer::set_look; then it is as before
    void set_look(const Look& look);
    const Camera& camera() const { return camera_; }

    /// The whole picture, with what can be drawn of it in that time.
    Step draw_coarse(double target_milliseconds);
    /// The next part, which takes about that time; nothing if all rounds are drawn.
    ///
    /// samples  of a pixel in the end, as in sample_shifts()
    std::optional<Step> refine(double target_milliseconds, int samples);
    /// Whether all samples are there.
    bool is_complete(int samples) const;
    /// Rounds that are complete: 0 while some of the canvas is coarse.
    int complete_rounds() const { return round_; }

    /// Into the window's own framebuffer, from (x, y) on its bottom left, in sRGB.
    void present(int x, int y) const;

    /// Instead of the picture, until something changes: a picture of the same view.
    void show_picture(const Image& picture);
    /// Instead of the picture: how often each ray looked at the field, up to so many in red.
    void show_steps(std::optional<int> most_steps);
    bool shows_steps() const { return most_steps_.has_value(); }

    const Pace& pace() const { return pace_; }

private:
    struct Part {
        PicturePart part;
        /// The sample whose hits are kept: of sample_shifts(), or -1, the pixels' middles.
        int kept = -1;
        int first = -1; // sample of the first round
        /// One that starts in the middle of its pixels ends without that sample.
        int rounds(int samples) const { return samples > 1 && first < 0 ? samples + 1 : samples; }
    };
    Step draw(const PicturePart& part, int width, int height);
    /// Gives the renderer the look, or less of it, unless it has that.
    void show_effects(bool has_all);
    void choose_parts(double target_milliseconds);
    /// What the renderer drew last.
    const gl::Texture& drawn() const;
    void show_coarse();
    /// What was drawn of `around` to the part's place.
    ///
    /// weight  of it beside what is there
    void add(const PicturePart& around, const PicturePart& part, double weight);
    /// Corners at the bottom left.
    ///
    /// is_shown  as the window shows it; else linear
    void copy(const gl::Texture& from, const Eigen::Vector2i& from_corner,
              const gl::Framebuffer& to, const Eigen::Vector2i& corner, const Eigen::Vector2i& size,
              bool is_shown, double weight);
    /// Enlarged to the canvas's size, from (x, y) on.
    void blit(const gl::Texture& from, const gl::Framebuffer& from_framebuffer, unsigned to, int x,
              int y) const;

    Renderer& renderer_;
    gl::ShaderLibrary shaders_;
    gl::VertexArray no_vertices_ = gl::VertexArray::without_attributes("canvas");
    gl::Texture image_; // linear
    gl::Framebuffer framebuffer_;
    gl::Texture shown_; // the same in sRGB
    gl::Framebuffer shown_framebuffer_;
    gl::Texture coarse_; // shown in its place, if there is one
    gl::Framebuffer coarse_framebuffer_;
    Camera camera_;
    Look look_;
    bool has_all_effects_ = true; // the renderer's look
    std::optional<int> most_steps_;
    Pace pace_;
    std::vector<Part> parts_; // none: they are to be chosen
    std::size_t next_ = 0;    // part of the round
    int round_ = 0;
};

} // namespace isocast::view
