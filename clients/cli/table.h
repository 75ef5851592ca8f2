// Prints aligned tables.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace cwm::cli {

enum class Align { kLeft, kRight };

struct Column {
  std::string title;
  Align align = Align::kLeft;
};

struct TableRow {
  std::vector<std::string> cells;  // one per column
  std::string note = {};           // printed below the row, indented; empty: none
};

enum class TableStyle { kPlain, kColor };

// Columns that are empty in every row are omitted. With colour, titles are bold.
void PrintTable(const std::vector<Column>& columns, const std::vector<TableRow>& rows,
                TableStyle style, std::ostream& out);

}  // namespace cwm::cli
