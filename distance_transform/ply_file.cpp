// Parses PLY: text, little- or big-endian; any properties and elements beside positions and faces.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/mesh_parsers.h"
#include "distance_transform/text_scanner.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

namespace isocast {

namespace {

enum class Format { Text, LittleEndian, BigEndian };

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

struct Property {
    std::string name;
    Type type;
    std::optional<Type> count_type; // of a list
};

struct Element {
    std::string name;
    std::int64_t count;
    std::vector<Property> properties;
};

struct Header {
    Format format;
    std::vector<Element> elements;
};

Type read_type(TextScanner& scanner) {
    const std::string_view found = scanner.token_on_line();
    for (const auto& [name, type] : type_names)
        if (found == name) return type;
    scanner.fail(fmt::format("unknown property type {}", quoted(found)));
}

Format read_format(TextScanner& scanner) {
    const std::string_view found = scanner.token_on_line();
    if (found == "ascii") return Format::Text;
    if (found == "binary_little_endian") return Format::LittleEndian;
    if (found == "binary_big_endian") return Format::BigEndian;
    scanner.fail(fmt::format("unknown format {} (known: ascii, binary_little_endian, "
                             "binary_big_endian)",
                             quoted(found)));
}

void read_property(TextScanner& scanner, Header& header) {
    if (header.elements.empty()) scanner.fail("a property before the first element");
    Property property;
    TextScanner ahead = scanner;
    if (ahead.token_on_line() == "list") {
        scanner = ahead;
        property.count_type = read_type(scanner);
    }
    property.type = read_type(scanner);
    property.name = scanner.token_on_line();
    header.elements.back().properties.push_back(std::move(property));
}

/// Reads up to and including the line "end_header".
Header read_header(TextScanner& scanner) {
    if (scanner.token_on_line() != "ply")
        scanner.fail("not a PLY file: it does not begin with 'ply'");
    std::optional<Format> format;
    Header header;
    for (;;) {
        scanner.next_line();
        if (scanner.is_at_end()) scanner.fail("truncated: the header has no 'end_header'");
        const std::string_view keyword = scanner.token_on_line();
        if (keyword == "format") {
            format = read_format(scanner);
        } else if (keyword == "element") {
            const std::string_view name = scanner.token_on_line();
            const std::int64_t count = scanner.integer_on_line("the number of elements");
            if (count < 0) scanner.fail("a number of elements is negative");
            header.elements.push_back({std::string(name), count, {}});
        } else if (keyword == "property") {
            read_property(scanner, header);
        } else if (keyword == "end_header") {
            break;
        } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
            scanner.fail(fmt::format("unexpected {} in the header", quoted(keyword)));
        }
    }
    scanner.next_line();
    if (!format) scanner.fail("the header has no 'format'");
    header.format = *format;
    return header;
}

/// Thrown where the data ends too early; caught where it is known which element that was.
struct EndOfData {};

/// The values of a text body.
class TextValues {
public:
    explicit TextValues(TextScanner& scanner) : scanner_(scanner) {}
    double next(Type) { return scanner_.number(token(), "a value"); }
    void skip(Type) { token(); }

private:
    std::string_view token() {
        const std::string_view found = scanner_.token();
        if (found.empty()) throw EndOfData{};
        return found;
    }
    TextScanner& scanner_;
};

/// The values of a binary body.
class BinaryValues {
public:
    BinaryValues(std::string_view bytes, bool swap) : bytes_(bytes), swap_(swap) {}

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
    void skip(Type type) { next(type); }

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

/// Where the parts of the mesh stand in the header.
struct Layout {
    const Element* vertex = nullptr;
    const Element* face = nullptr;    // absent from a file of points
    std::vector<std::size_t> numbers; // where x, y, z, and nx, ny, nz if there are any, stand
    std::size_t corners = 0;
};

const Element& find_element(const Header& header, std::string_view wanted, std::string_view name) {
    const Element* found = nullptr;
    std::vector<std::string_view> present;
    for (const Element& element : header.elements) {
        present.push_back(element.name);
        if (element.name != wanted) continue;
        if (found)
            throw InputError(fmt::format("{}: the header has two elements '{}'", name, wanted));
        found = &element;
    }
    if (!found)
        throw InputError(
            fmt::format("{}: the header has no element '{}' (has: {}){}", name, wanted,
                        fmt::join(present, ", "),
                        wanted == "face" ? "; convert --method points takes points" : ""));
    return *found;
}

std::size_t find_property(const Element& element, std::span<const std::string_view> wanted,
                          bool is_list, std::string_view name) {
    std::vector<std::string_view> present;
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const Property& property = element.properties[i];
        present.push_back(property.name);
        if (std::find(wanted.begin(), wanted.end(), property.name) != wanted.end() &&
            property.count_type.has_value() == is_list)
            return i;
    }
    throw InputError(fmt::format("{}: element '{}' has no {} '{}' (has: {})", name, element.name,
                                 is_list ? "list" : "number", wanted[0], fmt::join(present, ", ")));
}

bool has_number(const Element& element, std::string_view wanted) {
    return std::ranges::any_of(element.properties, [&](const Property& property) {
        return property.name == wanted && !property.count_type;
    });
}

Layout layout_of(const Header& header, std::string_view name, bool with_normals) {
    static constexpr std::array<std::string_view, 6> numbers = {"x", "y", "z", "nx", "ny", "nz"};
    static constexpr std::array<std::string_view, 2> lists = {"vertex_indices", "vertex_index"};
    Layout layout;
    layout.vertex = &find_element(header, "vertex", name);
    const bool is_mesh =
        !with_normals ||
        std::ranges::find(header.elements, "face", &Element::name) != header.elements.end();
    if (is_mesh) layout.face = &find_element(header, "face", name);
    const bool has_normals = with_normals && has_number(*layout.vertex, "nx");
    for (std::size_t k = 0; k < (has_normals ? 6 : 3); ++k)
        layout.numbers.push_back(
            find_property(*layout.vertex, std::span(&numbers[k], 1), false, name));
    if (is_mesh) layout.corners = find_property(*layout.face, lists, true, name);
    return layout;
}

/// An element of the file, for messages.
struct Place {
    std::string_view file;
    std::string_view element;
    std::int64_t index;
    std::string text() const { return fmt::format("{}: {} {}", file, element, index); }
};

/// Length of the list that comes next. A lying one ends at the end of the data, since nothing is
/// reserved for it.
template<class Values>
std::int64_t read_list_length(Values& values, Type type, const Place& where) {
    const double length = values.next(type);
    // Beyond 2^32 no count type reaches, and a text can hold anything.
    if (!(length >= 0 && length <= 4294967296.0) || length != std::floor(length))
        throw InputError(fmt::format("{}: a list has {} entries", where.text(), length));
    return static_cast<std::int64_t>(length);
}

template<class Values>
void skip_property(Values& values, const Property& property, const Place& where) {
    const std::int64_t count =
        property.count_type ? read_list_length(values, *property.count_type, where) : 1;
    for (std::int64_t i = 0; i < count; ++i) values.skip(property.type);
}

template<class Values>
void read_vertex(Values& values, const Layout& layout, std::vector<Vec3d>& positions,
                 std::vector<Vec3d>& normals, const Place& where) {
    std::array<double, 6> numbers{};
    for (std::size_t i = 0; i < layout.vertex->properties.size(); ++i) {
        const Property& property = layout.vertex->properties[i];
        const auto wanted = std::ranges::find(layout.numbers, i);
        if (wanted == layout.numbers.end()) {
            skip_property(values, property, where);
            continue;
        }
        const double number = values.next(property.type);
        if (!std::isfinite(number))
            throw InputError(fmt::format("{}: {} is not finite", where.text(), property.name));
        numbers[static_cast<std::size_t>(wanted - layout.numbers.begin())] = number;
    }
    positions.emplace_back(numbers[0], numbers[1], numbers[2]);
    if (layout.numbers.size() > 3) normals.emplace_back(numbers[3], numbers[4], numbers[5]);
}

template<class Values>
void read_face(Values& values, const Layout& layout, std::vector<int>& polygon,
               const Place& where) {
    polygon.clear();
    for (std::size_t i = 0; i < layout.face->properties.size(); ++i) {
        const Property& property = layout.face->properties[i];
        if (i != layout.corners) {
            skip_property(values, property, where);
            continue;
        }
        const std::int64_t corners = read_list_length(values, *property.count_type, where);
        if (corners < 3) throw InputError(fmt::format("{} has {} corners", where.text(), corners));
        for (std::int64_t k = 0; k < corners; ++k) {
            const double index = values.next(property.type);
            const auto vertices = static_cast<double>(layout.vertex->count);
            if (!(index >= 0 && index < vertices) || index != std::floor(index))
                throw InputError(
                    fmt::format("{}: vertex index {} is out of range: there are {} vertices",
                                where.text(), index, layout.vertex->count));
            polygon.push_back(static_cast<int>(index));
        }
    }
}

template<class Values>
Mesh read_body(Values values, const Header& header, std::string_view name,
               std::vector<Vec3d>* vertex_normals, std::vector<int>* corner_counts) {
    const Layout layout = layout_of(header, name, vertex_normals != nullptr);
    if (layout.vertex->count > std::numeric_limits<int>::max())
        throw InputError(fmt::format("{}: {} vertices are too many", name, layout.vertex->count));
    Mesh mesh;
    std::vector<Vec3d> normals;
    std::vector<int> polygon;
    for (const Element& element : header.elements) {
        if (element.properties.empty()) continue; // takes no space, however many there are
        std::int64_t i = 0;
        try {
            for (; i < element.count; ++i) {
                const Place where{name, element.name, i};
                if (&element == layout.vertex) {
                    read_vertex(values, layout, mesh.vertices_world, normals, where);
                } else if (&element == layout.face) {
                    read_face(values, layout, polygon, where);
                    append_fan(mesh, polygon);
                    if (corner_counts) corner_counts->push_back(static_cast<int>(polygon.size()));
                } else {
                    for (const Property& property : element.properties)
                        skip_property(values, property, where);
                }
            }
        } catch (const EndOfData&) {
            throw InputError(fmt::format("{}: truncated: it holds {} of {} elements '{}'", name, i,
                                         element.count, element.name));
        }
    }
    if (vertex_normals) *vertex_normals = std::move(normals);
    return mesh;
}

} // namespace

Mesh parse_ply(std::string_view bytes, std::string_view name, std::vector<Vec3d>* vertex_normals,
               std::vector<int>* corner_counts) {
    TextScanner scanner(bytes, name, {});
    const Header header = read_header(scanner);
    if (header.format == Format::Text)
        return read_body(TextValues(scanner), header, name, vertex_normals, corner_counts);
    const bool is_little = header.format == Format::LittleEndian;
    const bool swap = is_little != (std::endian::native == std::endian::little);
    return read_body(BinaryValues(bytes.substr(std::min(scanner.position(), bytes.size())), swap),
                     header, name, vertex_normals, corner_counts);
}

Mesh parse_ply(std::string_view bytes, std::string_view name) {
    return parse_ply(bytes, name, nullptr);
}

} // namespace isocast
