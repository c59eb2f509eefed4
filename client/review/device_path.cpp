#include "client/review/device_path.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

namespace tandem::client {

namespace {

/// The cells of a line as numbers; false if a cell is not a number at all (nan and inf are).
bool parseCells(const std::string& line, std::vector<double>& cells) {
  cells.clear();
  std::istringstream stream(line);
  std::string cell;
  while (std::getline(stream, cell, ',')) {
    char* end = nullptr;
    const double value = std::strtod(cell.c_str(), &end);
    while (*end == ' ' || *end == '\r') ++end;
    if (end == cell.c_str() || *end != '\0') return false;
    cells.push_back(value);
  }
  return true;
}

std::string cell(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

}  // namespace

Result<std::vector<PathRow>> loadDevicePath(const std::string& path) {
  std::error_code unreadable;
  if (std::filesystem::is_directory(path, unreadable)) return Error{path + ": is a directory"};
  std::ifstream file(path);
  if (!file) return Error{path + ": cannot be read"};
  std::string line;
  std::getline(file, line);
  if (!line.empty() && line.back() == '\r') line.pop_back();
  const bool turns = line == "t,x,y,z,qw,qx,qy,qz";
  if (!turns && line != "t,x,y,z")
    return Error{path + ": line 1: the header must be t,x,y,z or t,x,y,z,qw,qx,qy,qz"};
  const std::size_t columns = turns ? 8 : 4;
  std::vector<PathRow> rows;
  std::vector<double> cells;
  double latest = -std::numeric_limits<double>::infinity();  // s
  for (std::size_t number = 2; std::getline(file, line); ++number) {
    if (line.empty() || line == "\r") continue;
    const std::string where = path + ": line " + std::to_string(number) + ": ";
    if (!parseCells(line, cells) || cells.size() != columns)
      return Error{where + "needs " + std::to_string(columns) + " numbers"};
    PathRow row;
    row.time = cells[0];
    row.pose.position = {cells[1], cells[2], cells[3]};
    bool finite = true;
    for (const double value : cells) finite = finite && std::isfinite(value);
    if (turns && finite) {
      const glm::dquat q(cells[4], cells[5], cells[6], cells[7]);
      const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
      if (std::abs(norm - 1.0) > 1e-2) return Error{where + "the quaternion is not a unit one"};
      row.pose.orientation = glm::normalize(q);
    }
    // A time that is not finite belongs to an invalid reading and does not count for the order.
    if (std::isfinite(row.time)) {
      if (row.time < latest)
        return Error{where + "the time goes backwards: " + cell(row.time) + " after " + cell(latest)};
      latest = row.time;
    }
    row.valid = finite;
    rows.push_back(row);
  }
  if (rows.empty()) return Error{path + ": holds no rows"};
  return rows;
}

}  // namespace tandem::client
