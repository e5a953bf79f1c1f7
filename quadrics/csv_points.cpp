// CSV: a line of names, then a line of cells for each point.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/point_parsers.h"
#include "quadrics/text_lines.h"
#include "volume/volume_file.h" // trimmed, number_of

#include <limits>

namespace isocast {

namespace {

/// The cells of a line, without the blanks and quotes about them.
///
/// source  RFC 4180, but without line breaks within quotes, and with blanks about cells that do not
///         count
std::vector<std::string> cells_of(const TextLines& lines, std::string_view line) {
    std::vector<std::string> cells;
    for (;;) {
        std::string cell;
        const std::size_t start = line.find_first_not_of(" \t");
        if (start != std::string_view::npos && line[start] == '"') {
            line.remove_prefix(start + 1);
            for (;;) {
                const std::size_t quote = line.find('"');
                if (quote == std::string_view::npos) lines.fail("a quote is not closed");
                cell += line.substr(0, quote);
                line.remove_prefix(quote + 1);
                if (!line.starts_with('"')) break;
                cell += '"'; // two quotes within quotes are one
                line.remove_prefix(1);
            }
            if (const std::string_view behind = trimmed(line.substr(0, line.find(',')));
                !behind.empty())
                lines.fail(fmt::format("'{}' follows a quoted cell", shown(behind)));
        } else {
            cell = trimmed(line.substr(0, line.find(',')));
        }
        cells.push_back(std::move(cell));
        const std::size_t comma = line.find(',');
        if (comma == std::string_view::npos) return cells;
        line.remove_prefix(comma + 1);
    }
}

} // namespace

PointData parse_csv_points(std::string_view bytes, const std::string& name) {
    if (bytes.starts_with("\xEF\xBB\xBF")) bytes.remove_prefix(3); // as spreadsheets mark UTF-8
    PointData points;
    std::vector<ColumnRange> ranges;
    TextLines lines(bytes, name);
    while (!lines.is_at_end()) {
        const std::string_view line = lines.next();
        if (const std::string_view text = trimmed(line); text.empty() || text.starts_with('#'))
            continue;
        std::vector<std::string> cells = cells_of(lines, line);
        if (points.names.empty()) {
            ranges = ranges_of(cells, fmt::format("{}:{}", name, lines.line()));
            points.names = std::move(cells);
            points.columns.resize(points.names.size());
            continue;
        }
        if (cells.size() != points.names.size())
            lines.fail(fmt::format("the line has {} cells, but there are {} columns", cells.size(),
                                   points.names.size()));
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const std::optional<double> number = number_of(cells[i]);
            if (!number && ranges[i].is_checked)
                lines.fail(
                    fmt::format("{}: '{}' is not a number", points.names[i], shown(cells[i])));
            const double value = number.value_or(std::numeric_limits<double>::quiet_NaN());
            if (const std::string problem = problem_of(ranges[i], value); !problem.empty())
                lines.fail(fmt::format("{}: {}", points.names[i], problem));
            points.columns[i].push_back(value);
        }
    }
    if (points.names.empty()) throw InputError(fmt::format("{}: there is no line of names", name));
    return points;
}

} // namespace isocast
