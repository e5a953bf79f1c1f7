// SPDX-License-Identifier: MPL-2.0
#include "apps/view/canvas.h"

#include "apps/picture.h"
#include "volume/stopwatch.h"

#include <glad/gl.h>

#include <algorithm>
#include <cmath>

namespace isocast::view {

namespace {

constexpr std::size_t most_parts = 48;

const gl::ProgramKey copy_program{{"view/triangle.vert", "view/copy.frag"}, {}};
const gl::ProgramKey present_program{{"view/triangle.vert", "view/present.frag"}, {}};

} // namespace

Canvas::Canvas(Renderer& renderer, const std::filesystem::path& shader_folder)
    : renderer_(renderer), shaders_({shader_folder}) {
    renderer_.keep_parts(most_parts + 1); // and the coarse one
}

void Canvas::resize(int width, int height) {
    framebuffer_ = {};
    image_ = {};
    image_ = gl::Texture::image(gl::Format::Rgba32f, width, height, "canvas");
    framebuffer_ = gl::Framebuffer({&image_}, "canvas");
    framebuffer_.bind();
    constexpr std::array<float, 4> grey{0.2F, 0.2F, 0.2F, 1};
    glClearBufferfv(GL_COLOR, 0, grey.data());
    restart(camera_);
}

void Canvas::restart(const Camera& camera) {
    camera_ = camera;
    parts_.clear();
    next_ = 0;
    round_ = 0;
}

void Canvas::restart_look() {
    for (Part& part : parts_) part.first = part.kept;
    next_ = 0;
    round_ = 0;
}

Step Canvas::draw(const PicturePart& part, int width, int height) {
    const Stopwatch watch;
    const FrameImage image = most_steps_ ? FrameImage::Steps : FrameImage::Beauty;
    Step step{.part = part, .width = width, .height = height};
    step.report = renderer_.draw(camera_, width, height, {image}, part);
    step.milliseconds = 1000 * watch.seconds();
    if (std::ranges::any_of(step.report.passes, &PassReport::ran))
        pace_.saw(step.report, double(part.width) * part.height, step.milliseconds);
    return step;
}

Step Canvas::draw_coarse(const Look& look, double target_milliseconds) {
    const Reduction reduction =
        pace_.reduction_for(look, double(width()) * height(), target_milliseconds);
    const int coarse_width = std::max(1, width() / reduction.divisor);
    const int coarse_height = std::max(1, height() / reduction.divisor);
    const Look shown = reduction.has_effects ? look : without_expensive_effects(look);
    if (renderer_.look() != shown) renderer_.set_look(shown);
    const PicturePart whole{.width = coarse_width, .height = coarse_height};
    Step step = draw(whole, coarse_width, coarse_height);
    step.is_coarse = true;
    copy(whole, whole, coarse_width, coarse_height, 1);
    parts_.clear();
    next_ = 0;
    round_ = 0;
    return step;
}

void Canvas::choose_parts(const Look& look, double target_milliseconds) {
    const double pixels = double(width()) * height();
    int count = 1;
    while (count < static_cast<int>(most_parts) &&
           pace_.expected_milliseconds(look, pixels / count, true) > target_milliseconds)
        ++count;
    // As square as they can be; even, since effects look at quads.
    const auto edge = static_cast<int>(std::ceil(std::sqrt(pixels / count)));
    const int even = std::max(32, (edge + 1) / 2 * 2);
    for (const PicturePart& part : parts_of(width(), height(), even, gl::max_image_extent()))
        parts_.push_back({part});
}

bool Canvas::is_complete(int samples) const {
    return !parts_.empty() && std::ranges::all_of(parts_, [&](const Part& part) {
        return round_ >= part.rounds(samples);
    });
}

std::optional<Step> Canvas::refine(const Look& look, double target_milliseconds, int samples) {
    if (is_complete(samples)) return std::nullopt;
    if (renderer_.look() != look) renderer_.set_look(look);
    if (parts_.empty()) choose_parts(look, target_milliseconds);
    while (round_ >= parts_[next_].rounds(samples)) next_ = (next_ + 1) % parts_.size();
    Part& part = parts_[next_];
    const bool has_middle = part.first < 0;
    const int sample = has_middle ? round_ - 1 : (part.first + round_) % samples;
    const int count = has_middle ? std::max(round_, 1) : round_ + 1;
    PicturePart drawn = with_reach(part.part, reach_pixels(look), width(), height());
    if (sample >= 0)
        drawn.shift = sample_shifts(samples, PixelFilter::Box)[static_cast<std::size_t>(sample)];
    part.kept = sample;
    Step step = draw(drawn, width(), height());
    copy(drawn, part.part, width(), height(), 1.0 / count);
    step.part = part.part;
    step.round = round_;
    do
        ++next_;
    while (next_ < parts_.size() && round_ >= parts_[next_].rounds(samples));
    if (next_ == parts_.size()) {
        next_ = 0;
        ++round_;
        step.ends_round = true;
    }
    return step;
}

void Canvas::copy(const PicturePart& drawn, const PicturePart& box, int width, int height,
                  double weight) {
    const gl::Program& program = shaders_.program(copy_program);
    renderer_.texture(most_steps_ ? FrameImage::Steps : FrameImage::Beauty).bind_to_unit(0);
    // Pictures have their first row at the top, textures at the bottom.
    const Eigen::Vector2d scale(double(width) / this->width(), double(height) / this->height());
    const Eigen::Vector2d origin(box.x, height - box.y - box.height);
    const Eigen::Vector2d to = origin.cwiseQuotient(scale);
    const Eigen::Vector2d from =
        origin - Eigen::Vector2d(drawn.x, height - drawn.y - drawn.height);
    program.set("u_to_origin", Eigen::Vector2f(to.cast<float>()));
    program.set("u_from_origin", Eigen::Vector2f(from.cast<float>()));
    program.set("u_from_size", Eigen::Vector2f(float(box.width), float(box.height)));
    program.set("u_scale", Eigen::Vector2f(scale.cast<float>()));
    program.set("u_most_steps", static_cast<float>(most_steps_.value_or(0)));
    framebuffer_.bind();
    glViewport(int(std::lround(to.x())), int(std::lround(to.y())),
               int(std::lround(box.width / scale.x())), int(std::lround(box.height / scale.y())));
    set_fixed_state();
    if (weight < 1) {
        glEnable(GL_BLEND);
        glBlendEquation(GL_FUNC_ADD);
        glBlendFunc(GL_CONSTANT_ALPHA, GL_ONE_MINUS_CONSTANT_ALPHA);
        glBlendColor(0, 0, 0, static_cast<float>(weight));
    }
    no_vertices_.bind();
    program.use();
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_BLEND);
}

void Canvas::present() {
    const gl::Program& program = shaders_.program(present_program);
    image_.bind_to_unit(0);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glViewport(0, 0, width(), height());
    set_fixed_state();
    no_vertices_.bind();
    program.use();
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Canvas::show_steps(std::optional<int> most_steps) {
    most_steps_ = most_steps;
    restart(camera_);
}

} // namespace isocast::view
