// SPDX-License-Identifier: MPL-2.0
#include "apps/key_kinds.h"

#include <charconv>
#include <cmath>

namespace isocast::keys {

namespace {

using Path = std::filesystem::path;

/// What a value is, for messages.
std::string described(const SceneValue& value) {
    struct Describe {
        std::string operator()(bool b) const { return b ? "true" : "false"; }
        std::string operator()(std::int64_t n) const { return std::to_string(n); }
        std::string operator()(double x) const { return fmt::format("{}", x); }
        std::string operator()(const std::string& text) const { return fmt::format("'{}'", text); }
        std::string operator()(const std::vector<double>& list) const {
            return fmt::format("{} numbers", list.size());
        }
        std::string operator()(const std::vector<std::string>& list) const {
            return fmt::format("{} texts", list.size());
        }
    };
    return std::visit(Describe{}, value);
}

bool is_builtin(const std::string& name) {
    return name.starts_with("field:") || name.starts_with("mesh:");
}

[[noreturn]] void fail(const char* expected, const SceneValue& value) {
    throw WrongType(fmt::format("expected {}, not {}", expected, described(value)));
}

} // namespace

double number_of(const SceneValue& value) {
    double number = std::numeric_limits<double>::quiet_NaN();
    if (const auto* integer = std::get_if<std::int64_t>(&value))
        number = static_cast<double>(*integer);
    else if (const auto* real = std::get_if<double>(&value))
        number = *real;
    if (!std::isfinite(number)) fail("a number", value);
    return number;
}

int integer_of(const SceneValue& value) {
    const auto* integer = std::get_if<std::int64_t>(&value);
    if (!integer || *integer != static_cast<int>(*integer)) fail("an integer", value);
    return static_cast<int>(*integer);
}

bool truth_of(const SceneValue& value) {
    const auto* truth = std::get_if<bool>(&value);
    if (!truth) fail("true or false", value);
    return *truth;
}

std::string text_of(const SceneValue& value) {
    const auto* text = std::get_if<std::string>(&value);
    if (!text) fail("text", value);
    return *text;
}

std::vector<std::string> texts_of(const SceneValue& value) {
    const auto* texts = std::get_if<std::vector<std::string>>(&value);
    if (!texts) fail("a list of texts", value);
    return *texts;
}

Vec3d vector_of(const SceneValue& value) {
    const auto* list = std::get_if<std::vector<double>>(&value);
    if (!list || list->size() != 3) fail("three numbers [x, y, z]", value);
    const Vec3d vector((*list)[0], (*list)[1], (*list)[2]);
    if (!vector.allFinite()) fail("three numbers [x, y, z]", value);
    return vector;
}

Vec3d colour_of(const SceneValue& value) {
    constexpr const char* expected = "a colour, [r, g, b] (linear, from 0) or \"#rrggbb\" (sRGB)";
    if (const auto* text = std::get_if<std::string>(&value)) {
        unsigned rgb = 0;
        const char* end = text->data() + text->size();
        if (text->size() != 7 || text->front() != '#' ||
            std::from_chars(text->data() + 1, end, rgb, 16).ptr != end)
            fail(expected, value);
        Vec3d colour;
        for (int c = 0; c < 3; ++c) colour[c] = linear_from_srgb(int(rgb >> (16 - 8 * c) & 0xff));
        return colour;
    }
    const auto* list = std::get_if<std::vector<double>>(&value);
    if (!list || list->size() != 3) fail(expected, value);
    const Vec3d colour((*list)[0], (*list)[1], (*list)[2]);
    if (!colour.allFinite() || !(colour.minCoeff() >= 0)) fail(expected, value);
    return colour;
}

Value value_of(const std::string& text) {
    return text.empty() ? Value() : text;
}

Value value_of(const std::vector<std::string>& texts) {
    return texts.empty() ? Value() : texts;
}

Value value_of(const Vec3d& vector) {
    return std::vector<double>(vector.begin(), vector.end());
}

Value value_of(const std::array<double, 2>& interval) {
    return std::vector<double>(interval.begin(), interval.end());
}

SceneFile new_scene() {
    SceneFile fresh;
    fresh.objects.resize(1);
    fresh.camera_keys.resize(1);
    fresh.animations.resize(1);
    fresh.cut.planes.resize(1);
    return fresh;
}

SceneKey special(std::string name, std::string type, std::string help, decltype(SceneKey::set) set,
                 decltype(SceneKey::get) get, bool is_number) {
    const Value initial = get(new_scene(), 0, {});
    return {std::move(name), std::move(type), initial ? written(*initial) : "",
            std::move(help), is_number,       std::move(set),
            std::move(get)};
}

std::string Range::text() const {
    const bool has_lo = std::isfinite(lo);
    const bool has_hi = std::isfinite(hi);
    if (has_lo && has_hi && !is_open) return fmt::format(" between {} and {}", lo, hi);
    if (has_lo && has_hi)
        return fmt::format(" above {} and {} {}", lo, is_open_above ? "below" : "up to", hi);
    return has_lo ? fmt::format(" {} {}", is_open ? "above" : "from", lo) : "";
}

double Range::checked(double value) const {
    const bool is_above = is_open ? value > lo : value >= lo;
    const bool is_below = is_open_above ? value < hi : value <= hi;
    if (!is_above || !is_below)
        throw UsageError(fmt::format("expected a number{}, not {}", text(), value));
    return value;
}

std::string resolved(const std::string& name, const Path& folder) {
    return is_builtin(name) ? name : (folder / name).string();
}

Value path_value(const std::string& path, const Path& folder) {
    if (path.empty() || is_builtin(path)) return value_of(path);
    // Links among the folders are followed, since .. means another folder behind one; the file
    // itself may be a link that lies in the folder.
    const Path file(path);
    const auto found = [](const Path& of) { return weakly_canonical(absolute(of / ".")); };
    const Path whole = found(file.parent_path()) / file.filename();
    const Path relative = whole.lexically_relative(found(folder));
    return (*relative.begin() == ".." ? whole : relative).string();
}

Value path_value_of_read(bool is_there, const std::string& path, const Path& folder) {
    if (is_there && path.empty()) throw InputError("what is there is from no file");
    return path_value(path, folder);
}

} // namespace isocast::keys
