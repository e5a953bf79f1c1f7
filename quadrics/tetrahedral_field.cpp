// SPDX-License-Identifier: MPL-2.0
#include "quadrics/tetrahedral_field.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

namespace isocast {

namespace {

/// Words of a text, apart by white space.
class Words {
public:
    Words(std::string_view text, std::string name) : rest_(text), name_(std::move(name)) {}

    /// Empty at the end.
    std::string_view next() {
        constexpr std::string_view blanks = " \t\r\n";
        rest_.remove_prefix(std::min(rest_.find_first_not_of(blanks), rest_.size()));
        const std::string_view word = rest_.substr(0, rest_.find_first_of(blanks));
        rest_.remove_prefix(word.size());
        return word;
    }
    void skip_line() {
        const std::size_t end = rest_.find('\n');
        rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    }
    template<class Number>
    Number number(const char* what) {
        const std::string_view word = next();
        Number value{};
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (word.empty()) fail(fmt::format("truncated: {} is missing", what));
        if (error != std::errc() || end != word.data() + word.size())
            fail(fmt::format("{} is not a number: '{}'", what, word));
        return value;
    }
    double finite(const char* what) {
        const auto value = number<double>(what);
        if (!std::isfinite(value)) fail(fmt::format("{} is not finite", what));
        return value;
    }
    std::int64_t count(const char* what) {
        const auto value = number<std::int64_t>(what);
        constexpr std::int64_t most = 1 << 28; // more would not fit the numbers of primitives
        if (value < 0 || value > most) fail(fmt::format("{} is {}", what, value));
        return value;
    }
    [[noreturn]] void fail(const std::string& cause) const {
        throw InputError(fmt::format("{}: {}", name_, cause));
    }

private:
    std::string_view rest_;
    std::string name_;
};

constexpr int linear_tetrahedron = 10;
constexpr int quadratic_tetrahedron = 24;
/// Of type 24: where tetrahedron_edges have their middles.
constexpr std::array<std::size_t, 6> middle_of_edge{4, 6, 7, 5, 8, 9};

struct File {
    std::vector<Vec3d> points;
    std::vector<std::vector<std::int64_t>> cells;
    std::vector<std::int64_t> types;
    std::vector<double> values;
};

File parsed(Words& words) {
    File file;
    std::int64_t values = 0;
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
        if (word == "DATASET") {
            if (words.next() != "UNSTRUCTURED_GRID") words.fail("it is no UNSTRUCTURED_GRID");
        } else if (word == "POINTS") {
            const std::int64_t count = words.count("the number of points");
            words.next(); // their type
            for (std::int64_t i = 0; i < count; ++i) {
                const double x = words.finite("x");
                const double y = words.finite("y");
                file.points.emplace_back(x, y, words.finite("z"));
            }
        } else if (word == "CELLS") {
            const std::int64_t count = words.count("the number of cells");
            words.count("the size of CELLS");
            for (std::int64_t i = 0; i < count; ++i) {
                auto& cell = file.cells.emplace_back();
                const std::int64_t corners = words.count("the number of a cell's points");
                for (std::int64_t k = 0; k < corners; ++k)
                    cell.push_back(words.count("a cell's point"));
            }
        } else if (word == "CELL_TYPES") {
            const std::int64_t count = words.count("the number of types");
            for (std::int64_t i = 0; i < count; ++i)
                file.types.push_back(words.count("a cell's type"));
        } else if (word == "POINT_DATA") {
            values = words.count("the number of values");
        } else if (word == "SCALARS" && values > 0 && file.values.empty()) {
            words.skip_line();
            if (words.next() != "LOOKUP_TABLE") words.fail("SCALARS without LOOKUP_TABLE");
            words.skip_line();
            for (std::int64_t i = 0; i < values; ++i)
                file.values.push_back(words.finite("a value"));
        }
    }
    return file;
}

} // namespace

TetrahedralField read_tetrahedra(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw InputError(fmt::format("{}: cannot open", path.string()));
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    Words words(text, path.string());
    if (!text.starts_with("# vtk DataFile")) words.fail("it does not begin with '# vtk DataFile'");
    words.skip_line();
    words.skip_line(); // the title
    if (words.next() != "ASCII") words.fail("it is not ASCII");
    File file = parsed(words);
    if (file.cells.empty()) words.fail("it has no cells");
    if (file.types.size() != file.cells.size())
        words.fail(fmt::format("{} types for {} cells", file.types.size(), file.cells.size()));
    if (file.values.size() != file.points.size())
        words.fail(fmt::format("{} values for {} points", file.values.size(), file.points.size()));
    TetrahedralField out;
    out.vertices_world = std::move(file.points);
    for (std::size_t i = 0; i < file.cells.size(); ++i) {
        const std::vector<std::int64_t>& cell = file.cells[i];
        const bool is_quadratic = file.types[i] == quadratic_tetrahedron;
        if (!is_quadratic && file.types[i] != linear_tetrahedron)
            words.fail(fmt::format("cell {} has the type {}, not {} or {}", i, file.types[i],
                                   linear_tetrahedron, quadratic_tetrahedron));
        if (cell.size() != (is_quadratic ? 10 : 4))
            words.fail(fmt::format("cell {} has {} points", i, cell.size()));
        for (const std::int64_t point : cell)
            if (point >= std::ssize(out.vertices_world))
                words.fail(fmt::format("cell {}: there is no point {}", i, point));
        const auto value = [&](std::size_t k) {
            return file.values[static_cast<std::size_t>(cell[k])];
        };
        const auto point = [&](std::size_t k) -> const Vec3d& {
            return out.vertices_world[static_cast<std::size_t>(cell[k])];
        };
        auto& corners = out.tetrahedra.emplace_back();
        auto& coefficients = out.coefficients.emplace_back();
        for (std::size_t k = 0; k < 4; ++k) {
            corners[k] = static_cast<int>(cell[k]);
            coefficients[k] = value(k);
        }
        for (std::size_t e = 0; e < 6; ++e) {
            const auto k = static_cast<std::size_t>(tetrahedron_edges[e][0]);
            const auto l = static_cast<std::size_t>(tetrahedron_edges[e][1]);
            const double mean = (value(k) + value(l)) / 2;
            coefficients[4 + e] = mean;
            if (!is_quadratic) continue;
            const std::size_t m = middle_of_edge[e];
            const double off = (point(m) - (point(k) + point(l)) / 2).norm();
            // 1e-6: what text of seven digits leaves.
            if (off > 1e-6 * (point(l) - point(k)).norm())
                words.fail(fmt::format("cell {}: point {} is not the middle of an edge: curved "
                                       "tetrahedra are no quadrics",
                                       i, cell[m]));
            // f(middle) = c_kk / 4 + c_kl / 2 + c_ll / 4
            coefficients[4 + e] = 2 * value(m) - mean;
        }
    }
    return out;
}

TetrahedralMesh isosurface(const TetrahedralField& field, double iso) {
    TetrahedralMesh mesh{
        .vertices_world = field.vertices_world, .tetrahedra = {}, .coefficients = {}};
    for (std::size_t i = 0; i < field.tetrahedra.size(); ++i) {
        std::array<float, 10> coefficients;
        for (std::size_t k = 0; k < 10; ++k)
            coefficients[k] = static_cast<float>(field.coefficients[i][k] - iso);
        append(mesh, field.tetrahedra[i], coefficients);
    }
    return mesh;
}

} // namespace isocast
