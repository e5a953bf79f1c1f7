// SPDX-License-Identifier: MPL-2.0
#include "apps/view/key_widgets.h"

#include "raycaster/image.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace isocast::view {

namespace {

/// "a", "b" of "\"a\" | \"b\"" or of "1 | 2".
std::vector<std::string> choices_of(const std::string& type) {
    std::vector<std::string> out;
    for (std::size_t begin = 0; begin < type.size();) {
        const std::size_t end = std::min(type.find(" | ", begin), type.size());
        std::string word = type.substr(begin, end - begin);
        std::erase(word, '"');
        out.push_back(word);
        begin = end + 3;
    }
    return out;
}

/// A name like 8 is a number.
SceneValue value_of_word(const std::string& word) {
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error == std::errc{} && end == word.data() + word.size()) return number;
    return word;
}

std::string word_of(const SceneValue& value) {
    if (const auto* text = std::get_if<std::string>(&value)) return *text;
    if (const auto* integer = std::get_if<std::int64_t>(&value)) return std::to_string(*integer);
    return "";
}

/// What a screen can show of it.
float srgb(double linear) {
    return srgb_encoded(static_cast<float>(std::clamp(linear, 0.0, 1.0)));
}

std::optional<SceneValue> combo(const char* label, const SceneKey& key,
                                const std::optional<SceneValue>& value) {
    std::optional<SceneValue> chosen;
    const std::string now = value ? word_of(*value) : "";
    if (!ImGui::BeginCombo(label, now.empty() ? "(as usual)" : now.c_str())) return chosen;
    for (const std::string& word : choices_of(key.type))
        if (!word.starts_with("file") && ImGui::Selectable(word.c_str(), word == now))
            chosen = value_of_word(word);
    ImGui::EndCombo();
    return chosen;
}

std::optional<SceneValue> number(const char* label, const SceneKey& key, double now,
                                 bool is_at_once) {
    bool is_changed = false;
    if (key.type == "number between 0 and 1") {
        const double lo = 0;
        const double hi = 1;
        is_changed = ImGui::SliderScalar(label, ImGuiDataType_Double, &now, &lo, &hi, "%.3g");
    } else {
        const auto speed = static_cast<float>(std::max(0.002 * std::abs(now), 1e-3));
        is_changed =
            ImGui::DragScalar(label, ImGuiDataType_Double, &now, speed, nullptr, nullptr, "%.4g");
    }
    if (is_changed && is_at_once) return now;
    return std::nullopt;
}

/// Typed, and taken by Enter.
std::optional<SceneValue> typed(const char* label, const SceneKey& key,
                                const std::optional<SceneValue>& value, std::string& text) {
    if (!ImGui::IsItemActive() && text.empty() && value) text = word_of(*value);
    const bool is_entered =
        ImGui::InputTextWithHint(label, "(as usual)", &text, ImGuiInputTextFlags_EnterReturnsTrue);
    if (!is_entered || text.empty()) return std::nullopt;
    if (key.is_number || key.type.starts_with("integer")) {
        double number = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
        if (key.type.starts_with("integer")) return static_cast<std::int64_t>(std::llround(number));
        return number;
    }
    return text;
}

} // namespace

std::optional<SceneValue> key_widget(const SceneKey& key, const std::optional<SceneValue>& value,
                                     bool is_at_once, std::string& text) {
    const char* label = key.name.c_str();
    if (key.type == "true | false") {
        bool is_on = value && std::get<bool>(*value);
        if (ImGui::Checkbox(label, &is_on)) return is_on;
        return std::nullopt;
    }
    if (key.type.find(" | ") != std::string::npos) return combo(label, key, value);
    if (value && key.type == "colour") {
        const auto& now = std::get<std::vector<double>>(*value);
        std::array<float, 3> shown{srgb(now[0]), srgb(now[1]), srgb(now[2])};
        if (ImGui::ColorEdit3(label, shown.data(), ImGuiColorEditFlags_NoInputs))
            return std::vector<double>{srgb_decoded(shown[0]), srgb_decoded(shown[1]),
                                       srgb_decoded(shown[2])};
        return std::nullopt;
    }
    if (value && key.type == "[x, y, z]") {
        auto now = std::get<std::vector<double>>(*value);
        if (ImGui::DragScalarN(label, ImGuiDataType_Double, now.data(), 3, 0.01F, nullptr, nullptr,
                               "%.3g") &&
            is_at_once)
            return now;
        return std::nullopt;
    }
    if (value && is_at_once && std::holds_alternative<double>(*value))
        return number(label, key, std::get<double>(*value), is_at_once);
    if (value && is_at_once && std::holds_alternative<std::int64_t>(*value)) {
        std::int64_t now = std::get<std::int64_t>(*value);
        if (ImGui::DragScalar(label, ImGuiDataType_S64, &now, 0.1F)) return now;
        return std::nullopt;
    }
    if (value && text.empty() && std::holds_alternative<double>(*value))
        text = fmt::format("{}", std::get<double>(*value));
    return typed(label, key, value, text);
}

} // namespace isocast::view
