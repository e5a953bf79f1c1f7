// PLY: the numbers of its vertices; text, little- or big-endian.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/point_parsers.h"
#include "quadrics/text_lines.h"
#include "volume/volume_file.h" // trimmed, number_of, words_of

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

namespace isocast {

namespace {

enum class Type { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };

struct TypeName {
    std::string_view name;
    Type type;
};

constexpr std::array type_names = {
    TypeName{"char", Type::Int8},      TypeName{"int8", Type::Int8},
    TypeName{"uchar", Type::Uint8},    TypeName{"uint8", Type::Uint8},
    TypeName{"short", Type::Int16},    TypeName{"int16", Type::Int16},
    TypeName{"ushort", Type::Uint16},  TypeName{"uint16", Type::Uint16},
    TypeName{"int", Type::Int32},      TypeName{"int32", Type::Int32},
    TypeName{"uint", Type::Uint32},    TypeName{"uint32", Type::Uint32},
    TypeName{"float", Type::Float32},  TypeName{"float32", Type::Float32},
    TypeName{"double", Type::Float64}, TypeName{"float64", Type::Float64},
};

std::size_t size_of(Type type) {
    constexpr std::array<std::size_t, 8> sizes = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[static_cast<std::size_t>(type)];
}

struct Property {
    std::string name;
    Type type = Type::Float32;
    std::optional<Type> count_type; // of a list
};

struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
};

enum class Body { Text, LittleEndian, BigEndian };

struct Header {
    Body body = Body::Text;
    std::vector<Element> elements;
    std::size_t vertex = 0; // its index in elements
};

Type type_of(const TextLines& lines, std::string_view word) {
    for (const auto& [name, type] : type_names)
        if (word == name) return type;
    lines.fail(fmt::format("unknown property type '{}'", shown(word)));
}

Body body_of(const TextLines& lines, std::string_view word) {
    if (word == "ascii") return Body::Text;
    if (word == "binary_little_endian") return Body::LittleEndian;
    if (word == "binary_big_endian") return Body::BigEndian;
    lines.fail(
        fmt::format("unknown format '{}' (known: ascii, binary_little_endian, binary_big_endian)",
                    shown(word)));
}

Element element_of(const TextLines& lines, std::span<const std::string_view> words) {
    if (words.size() != 3) lines.fail("'element', a name and a number are expected");
    const std::optional<double> count = number_of(words[2]);
    // 2^31 - 1: more would not fit the memory that the primitives take.
    if (!count || !(*count >= 0 && *count < 0x1p31) || *count != std::floor(*count))
        lines.fail(fmt::format("'{}' is not a number of elements", shown(words[2])));
    return {std::string(words[1]), static_cast<std::size_t>(*count), {}};
}

Property property_of(const TextLines& lines, std::span<const std::string_view> words) {
    const bool is_list = words.size() > 1 && words[1] == "list";
    if (words.size() != (is_list ? 5 : 3)) lines.fail("'property', a type and a name are expected");
    Property property{.name = std::string(words.back()),
                      .type = type_of(lines, words[words.size() - 2])};
    if (is_list) property.count_type = type_of(lines, words[2]);
    return property;
}

/// Up to and including the line "end_header".
Header header_of(TextLines& lines) {
    if (trimmed(lines.next()) != "ply") lines.fail("not a PLY file: it does not begin with 'ply'");
    Header header;
    std::optional<Body> body;
    std::optional<std::size_t> vertex;
    for (;;) {
        if (lines.is_at_end()) lines.fail("truncated: the header has no 'end_header'");
        const std::vector<std::string_view> words = words_of(lines.next());
        if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
        if (words[0] == "end_header") break;
        if (words[0] == "format") {
            if (body) lines.fail("a second 'format'");
            body = body_of(lines, words.size() > 1 ? words[1] : "");
        } else if (words[0] == "element") {
            header.elements.push_back(element_of(lines, words));
            if (header.elements.back().name == "vertex") {
                if (vertex) lines.fail("a second element 'vertex'");
                vertex = header.elements.size() - 1;
            }
        } else if (words[0] == "property") {
            if (header.elements.empty()) lines.fail("a property before the first element");
            header.elements.back().properties.push_back(property_of(lines, words));
        } else {
            lines.fail(fmt::format("unexpected '{}' in the header", shown(words[0])));
        }
    }
    if (!body) lines.fail("the header has no 'format'");
    if (!vertex) lines.fail("the header has no element 'vertex'");
    header.body = *body;
    header.vertex = *vertex;
    return header;
}

/// The length of a list as a file says it; nothing is reserved for it.
std::optional<std::size_t> list_length(double value) {
    // Beyond 2^32 no count type reaches, and a text can hold anything.
    if (!(value >= 0 && value <= 0x1p32) || value != std::floor(value)) return std::nullopt;
    return static_cast<std::size_t>(value);
}

/// Columns that are filled row by row.
class Table {
public:
    Table(const Element& vertex, const std::string& file) {
        for (const Property& property : vertex.properties)
            if (!property.count_type) points_.names.push_back(property.name);
        ranges_ = ranges_of(points_.names, file);
        points_.columns.resize(points_.names.size());
    }
    void reserve(std::size_t count) {
        for (auto& column : points_.columns) column.reserve(count);
    }
    /// returns  why not, if it cannot be added
    std::string add(std::size_t column, double value) {
        points_.columns[column].push_back(value);
        const std::string problem = problem_of(ranges_[column], value);
        return problem.empty() ? "" : fmt::format("{}: {}", points_.names[column], problem);
    }
    PointData take() { return std::move(points_); }

private:
    PointData points_;
    std::vector<ColumnRange> ranges_;
};

/// A line holds an element.
PointData points_of_text(const Header& header, TextLines& lines, const std::string& name) {
    Table table(header.elements[header.vertex], name);
    const auto next_line = [&] {
        while (!lines.is_at_end())
            if (const std::string_view line = lines.next(); !trimmed(line).empty()) return line;
        return std::string_view();
    };
    for (const Element& element : header.elements) {
        if (element.properties.empty()) continue; // takes no line
        for (std::size_t i = 0; i < element.count; ++i) {
            const std::string_view line = next_line();
            if (line.empty())
                lines.fail(fmt::format("truncated: the file ends after {} of {} elements '{}'", i,
                                       element.count, element.name));
            if (element.name != "vertex") continue;
            const std::vector<std::string_view> words = words_of(line);
            std::size_t at = 0, column = 0;
            const auto next_number = [&](const Property& property) {
                if (at == words.size())
                    lines.fail(fmt::format("the line ends before {}", shown(property.name)));
                const std::optional<double> number = number_of(words[at++]);
                if (!number)
                    lines.fail(fmt::format("{}: '{}' is not a number", shown(property.name),
                                           shown(words[at - 1])));
                return *number;
            };
            for (const Property& property : element.properties) {
                const double number = next_number(property);
                if (property.count_type) {
                    const std::optional<std::size_t> length = list_length(number);
                    if (!length || *length > words.size() - at)
                        lines.fail(
                            fmt::format("the line does not hold a list of {} entries", number));
                    at += *length;
                } else if (const std::string problem = table.add(column++, number);
                           !problem.empty()) {
                    lines.fail(problem);
                }
            }
            if (at < words.size())
                lines.fail(fmt::format("the line has {} values too many", words.size() - at));
        }
    }
    if (!next_line().empty()) lines.fail("more lines than the header has elements");
    return table.take();
}

/// Thrown where the data ends too early; caught where it is known which element that was.
struct EndOfData {};

class BinaryValues {
public:
    BinaryValues(std::string_view bytes, bool swap) : bytes_(bytes), swap_(swap) {}

    std::size_t left() const { return bytes_.size(); }
    void skip(std::size_t size) {
        if (bytes_.size() < size) throw EndOfData{};
        bytes_.remove_prefix(size);
    }
    double next(Type type) {
        switch (type) {
        case Type::Int8:
            return read<std::int8_t>();
        case Type::Uint8:
            return read<std::uint8_t>();
        case Type::Int16:
            return read<std::int16_t>();
        case Type::Uint16:
            return read<std::uint16_t>();
        case Type::Int32:
            return read<std::int32_t>();
        case Type::Uint32:
            return read<std::uint32_t>();
        case Type::Float32:
            return static_cast<double>(read<float>());
        case Type::Float64:
            break;
        }
        return read<double>();
    }

private:
    template<class T>
    T read() {
        if (bytes_.size() < sizeof(T)) throw EndOfData{};
        std::array<char, sizeof(T)> raw;
        std::memcpy(raw.data(), bytes_.data(), sizeof(T));
        if (swap_) std::reverse(raw.begin(), raw.end());
        bytes_.remove_prefix(sizeof(T));
        return std::bit_cast<T>(raw);
    }
    std::string_view bytes_;
    bool swap_;
};

PointData points_of_binary(const Header& header, BinaryValues values, const std::string& name) {
    Table table(header.elements[header.vertex], name);
    for (const Element& element : header.elements) {
        if (element.properties.empty()) continue; // takes no space, however many there are
        std::size_t stride = 0;
        bool has_lists = false;
        for (const Property& property : element.properties) {
            has_lists = has_lists || property.count_type;
            stride += size_of(property.count_type.value_or(property.type));
        }
        const bool is_vertex = element.name == "vertex";
        std::size_t i = 0;
        const auto fail = [&](const std::string& cause) {
            throw InputError(fmt::format("{}: {} {}: {}", name, shown(element.name), i, cause));
        };
        try {
            if (const std::size_t most = values.left() / stride; element.count > most) {
                i = most;
                throw EndOfData{};
            }
            if (is_vertex) table.reserve(element.count);
            if (!is_vertex && !has_lists) {
                values.skip(element.count * stride);
                continue;
            }
            for (; i < element.count; ++i) {
                std::size_t column = 0;
                for (const Property& property : element.properties) {
                    if (property.count_type) {
                        const double number = values.next(*property.count_type);
                        const std::optional<std::size_t> length = list_length(number);
                        if (!length) fail(fmt::format("a list has {} entries", number));
                        values.skip(*length * size_of(property.type));
                    } else if (!is_vertex) {
                        values.skip(size_of(property.type));
                    } else if (const std::string problem =
                                   table.add(column++, values.next(property.type));
                               !problem.empty()) {
                        fail(problem);
                    }
                }
            }
        } catch (const EndOfData&) {
            throw InputError(fmt::format("{}: truncated: it holds at most {} of {} elements '{}'",
                                         name, i, element.count, shown(element.name)));
        }
    }
    if (values.left() > 0)
        throw InputError(fmt::format("{}: {} bytes follow the last element", name, values.left()));
    return table.take();
}

} // namespace

PointData parse_ply_points(std::string_view bytes, const std::string& name) {
    TextLines lines(bytes, name);
    const Header header = header_of(lines);
    if (header.body == Body::Text) return points_of_text(header, lines, name);
    const bool is_little = header.body == Body::LittleEndian;
    const bool swap = is_little != (std::endian::native == std::endian::little);
    return points_of_binary(header, BinaryValues(lines.rest(), swap), name);
}

} // namespace isocast
