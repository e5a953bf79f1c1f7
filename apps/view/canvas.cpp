// SPDX-License-Identifier: MPL-2.0
#include "apps/view/canvas.h"

#include "apps/picture.h"
#include "volume/stopwatch.h"

#include <glad/gl.h>

#include <algorithm>
#include <cmath>

namespace isocast::view {

namespace {

constexpr std::size_t most_parts = 48; // about: rows and columns are whole

gl::ProgramKey copy_program(bool is_shown) {
    return {{"view/triangle.vert", "view/copy.frag"}, {{"IS_SHOWN", is_shown ? "1" : "0"}}};
}

} // namespace

std::vector<gl::ProgramKey> canvas_programs() {
    return {copy_program(false), copy_program(true)};
}

Canvas::Canvas(Renderer& renderer, const std::filesystem::path& shader_folder)
    : renderer_(renderer), shaders_({shader_folder}) {
    renderer_.keep_parts(2 * most_parts);
}

void Canvas::resize(int width, int height) {
    // Old textures go first, so that they and the new are never both in memory.
    framebuffer_ = {};
    shown_framebuffer_ = {};
    coarse_framebuffer_ = {};
    image_ = {};
    shown_ = {};
    coarse_ = {};
    image_ = gl::Texture::image(gl::Format::Rgba32f, width, height, "canvas");
    framebuffer_ = gl::Framebuffer({&image_}, "canvas");
    shown_ = gl::Texture::image(gl::Format::Rgba8, width, height, "shown");
    shown_framebuffer_ = gl::Framebuffer({&shown_}, "shown");
    shown_framebuffer_.bind();
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

void Canvas::set_look(const Look& look) {
    renderer_.set_look(look);
    look_ = look;
    has_all_effects_ = true;
    for (Part& part : parts_) part.first = part.kept;
    next_ = 0;
    round_ = 0;
}

void Canvas::show_effects(bool has_all) {
    if (has_all == has_all_effects_) return;
    renderer_.set_look(has_all ? look_ : without_expensive_effects(look_));
    has_all_effects_ = has_all;
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

Step Canvas::draw_coarse(double target_milliseconds) {
    const Reduction reduction =
        pace_.reduction_for(look_, double(width()) * height(), target_milliseconds);
    const int coarse_width = std::max(1, width() / reduction.divisor);
    const int coarse_height = std::max(1, height() / reduction.divisor);
    show_effects(reduction.has_effects);
    const PicturePart whole{.width = coarse_width, .height = coarse_height};
    Step step = draw(whole, coarse_width, coarse_height);
    step.is_coarse = true;
    show_coarse();
    parts_.clear();
    next_ = 0;
    round_ = 0;
    return step;
}

void Canvas::choose_parts(double target_milliseconds) {
    const double pixels = double(width()) * height();
    int count = 1;
    while (count < static_cast<int>(most_parts) &&
           pace_.expected_milliseconds(look_, pixels / count, true) > target_milliseconds)
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

std::optional<Step> Canvas::refine(double target_milliseconds, int samples) {
    if (is_complete(samples)) return std::nullopt;
    if (!coarse_.is_empty()) { // until parts take its place
        blit(coarse_, coarse_framebuffer_, shown_framebuffer_.id(), 0, 0);
        coarse_framebuffer_ = {};
        coarse_ = {};
    }
    show_effects(true);
    if (parts_.empty()) choose_parts(target_milliseconds);
    while (round_ >= parts_[next_].rounds(samples)) next_ = (next_ + 1) % parts_.size();
    Part& part = parts_[next_];
    const bool has_middle = part.first < 0;
    const int sample = has_middle ? round_ - 1 : (part.first + round_) % samples;
    const int count = has_middle ? std::max(round_, 1) : round_ + 1;
    PicturePart around = with_reach(part.part, reach_pixels(look_), width(), height());
    if (sample >= 0)
        around.shift = sample_shifts(samples, PixelFilter::Box)[static_cast<std::size_t>(sample)];
    part.kept = sample;
    Step step = draw(around, width(), height());
    add(around, part.part, 1.0 / count);
    step.part = part.part;
    step.round = round_;
    do ++next_;
    while (next_ < parts_.size() && round_ >= parts_[next_].rounds(samples));
    if (next_ == parts_.size()) {
        next_ = 0;
        ++round_;
        step.ends_round = true;
    }
    return step;
}

void Canvas::copy(const gl::Texture& from, const Eigen::Vector2i& from_corner,
                  const gl::Framebuffer& to, const Eigen::Vector2i& corner,
                  const Eigen::Vector2i& size, bool is_shown, double weight) {
    const gl::Program& program = shaders_.program(copy_program(is_shown));
    from.bind_to_unit(0);
    program.set("u_from_to", Eigen::Vector2i(from_corner - corner));
    const bool has_steps = most_steps_ && &from != &image_;
    program.set("u_most_steps", has_steps ? static_cast<float>(*most_steps_) : 0.0F);
    to.bind();
    glViewport(corner.x(), corner.y(), size.x(), size.y());
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

const gl::Texture& Canvas::drawn() const {
    return renderer_.texture(most_steps_ ? FrameImage::Steps : FrameImage::Beauty);
}

void Canvas::show_coarse() {
    const gl::Texture& from = drawn();
    coarse_framebuffer_ = {};
    coarse_ = {};
    coarse_ = gl::Texture::image(gl::Format::Rgba8, from.width(), from.height(), "coarse");
    coarse_framebuffer_ = gl::Framebuffer({&coarse_}, "coarse");
    copy(from, {0, 0}, coarse_framebuffer_, {0, 0}, {from.width(), from.height()}, true, 1);
}

void Canvas::add(const PicturePart& around, const PicturePart& part, double weight) {
    // Pictures have their first row at the top, textures at the bottom.
    const Eigen::Vector2i corner(part.x, height() - part.y - part.height);
    const Eigen::Vector2i in_drawn(part.x - around.x,
                                   around.y + around.height - part.y - part.height);
    const Eigen::Vector2i size(part.width, part.height);
    copy(drawn(), in_drawn, framebuffer_, corner, size, false, weight);
    copy(image_, corner, shown_framebuffer_, corner, size, true, 1);
}

void Canvas::blit(const gl::Texture& from, const gl::Framebuffer& from_framebuffer, unsigned to,
                  int x, int y) const {
    glBlitNamedFramebuffer(from_framebuffer.id(), to, 0, 0, from.width(), from.height(), x, y,
                           x + width(), y + height(), GL_COLOR_BUFFER_BIT, GL_LINEAR);
}

void Canvas::present(int x, int y) const {
    // What panels will cover, too: they are seen through.
    constexpr std::array<float, 4> dark{0.06F, 0.06F, 0.06F, 1};
    glClearNamedFramebufferfv(0, GL_COLOR, 0, dark.data());
    if (coarse_.is_empty())
        blit(shown_, shown_framebuffer_, 0, x, y);
    else
        blit(coarse_, coarse_framebuffer_, 0, x, y);
    glBindFramebuffer(GL_FRAMEBUFFER, 0); // what comes on top goes there
}

void Canvas::show_picture(const Image& picture) {
    coarse_framebuffer_ = {};
    coarse_ = gl::Texture::picture(gl::Format::Rgba8, picture.width, picture.height,
                                   bottom_up(picture), gl::Wrap::Clamp, "shown picture");
    coarse_framebuffer_ = gl::Framebuffer({&coarse_}, "shown picture");
}

void Canvas::show_steps(std::optional<int> most_steps) {
    most_steps_ = most_steps;
    restart(camera_);
}

} // namespace isocast::view
