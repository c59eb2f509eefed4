#include "server/journal/session_rows.h"

#include <algorithm>
#include <limits>

#include "assets/base/printable.h"
#include "sync/wire/document_codec.h"
#include "sync/wire/limits.h"

namespace tandem::server {
namespace {

bool within(std::int64_t value, std::int64_t least, std::int64_t most) {
  return value >= least && value <= most;
}

}  // namespace

std::optional<sync::PartRecord> partOf(const SqliteStatement& row) {
  if (!within(row.integer(0), 0, kNoPart - 1) || !within(row.integer(1), 0, 0xffff) ||
      !within(row.integer(2), 0, 0xffffffff))
    return std::nullopt;
  sync::PartRecord part;
  part.part = static_cast<PartId>(row.integer(0));
  part.owner = static_cast<SiteId>(row.integer(1));
  part.epoch = static_cast<Epoch>(row.integer(2));
  part.worldFromPart.position = glm::dvec3(row.real(3), row.real(4), row.real(5));
  part.worldFromPart.orientation = glm::dquat(row.real(6), row.real(7), row.real(8), row.real(9));
  if (!isValid(part.worldFromPart)) return std::nullopt;
  return part;
}

std::optional<SiteRecord> siteOf(const SqliteStatement& row) {
  if (!within(row.integer(0), 1, 0xffff) ||
      !within(row.integer(1), 0, static_cast<int>(sync::Role::instructor)))
    return std::nullopt;
  SiteRecord site;
  site.info.site = static_cast<SiteId>(row.integer(0));
  site.info.role = static_cast<sync::Role>(row.integer(1));
  site.info.name = row.text(2);
  for (int i = 0; i < 3; ++i) {
    if (!within(row.integer(3 + i), 0, 255)) return std::nullopt;
    site.info.colour[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(row.integer(3 + i));
  }
  site.info.connected = false;
  site.left = row.integer(6) != 0;
  if (site.info.name.size() > sync::kMaxNameLength) return std::nullopt;
  return site;
}

std::optional<UsedNonce> nonceOf(const SqliteStatement& row) {
  return UsedNonce{row.text(0), row.integer(1)};
}

std::optional<DocumentRecord> entryOf(const SqliteStatement& row) {
  const std::string text = row.text(1);
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  const Result<document::Entry> entry = sync::decodeEntry(bytes);
  if (!entry || static_cast<std::int64_t>(entry->id) != row.integer(0)) return std::nullopt;
  return DocumentRecord{*entry, 0};
}

std::optional<SaidRecord> saidOf(const SqliteStatement& row) {
  if (!within(row.integer(1), 1, std::numeric_limits<std::int64_t>::max() - 1) ||
      !within(row.integer(2), 0, sync::kMaxUnixTime) || !within(row.integer(3), 1, 0xffff))
    return std::nullopt;
  SaidRecord said;
  said.line.number = static_cast<std::uint64_t>(row.integer(1));
  said.line.at = row.integer(2);
  said.line.site = static_cast<SiteId>(row.integer(3));
  said.line.name = row.text(4);
  said.line.said.text = row.text(5);
  const std::string parts = row.text(6);
  for (std::size_t i = 0; i + 1 < parts.size(); i += 2)
    said.line.said.parts.push_back(static_cast<PartId>(static_cast<std::uint8_t>(parts[i]) |
                                                       static_cast<std::uint8_t>(parts[i + 1]) << 8));
  const sync::Say& words = said.line.said;
  const bool sound = static_cast<std::int64_t>(said.slot()) == row.integer(0) && parts.size() % 2 == 0 &&
                     words.parts.size() <= sync::kMaxSaidParts && !words.text.empty() &&
                     words.text.size() <= sync::kMaxSayLength && isPrintable(words.text) &&
                     said.line.name.size() <= sync::kMaxNameLength && isPrintable(said.line.name);
  if (!sound) return std::nullopt;
  return said;
}

std::string partBytesOf(const sync::SaidLine& line) {
  std::string bytes;
  for (const PartId part : line.said.parts) {
    bytes.push_back(static_cast<char>(part & 0xffu));
    bytes.push_back(static_cast<char>(part >> 8));
  }
  return bytes;
}

Digest digestIn(const SqliteStatement& row, int column) {
  Digest digest{};
  const std::string bytes = row.text(column);
  if (bytes.size() == digest.size()) std::copy(bytes.begin(), bytes.end(), digest.begin());
  return digest;
}

Result<Version1> readVersion1(SqliteDatabase& database) {
  Version1 found;
  const auto take = [](const char* table, const auto& record, auto& into) {
    if (!record) return std::string("damaged: table ") + table + " holds a value out of range";
    into.push_back(*record);
    return std::string();
  };
  JournalContents& contents = found.contents;
  Status read =
      readRows(database, "SELECT part, owner, epoch, px, py, pz, qw, qx, qy, qz FROM parts ORDER BY part",
               [&](const SqliteStatement& row) { return take("parts", partOf(row), contents.parts); });
  if (!read) return read.error();
  read = readRows(database, "SELECT site, role, name, red, green, blue, gone FROM sites ORDER BY site",
                  [&](const SqliteStatement& row) { return take("sites", siteOf(row), contents.sites); });
  if (!read) return read.error();
  read = readRows(database, "SELECT nonce, expires FROM nonces",
                  [&](const SqliteStatement& row) { return take("nonces", nonceOf(row), contents.nonces); });
  if (!read) return read.error();
  read = readRows(database,
                  "SELECT CAST(max(CASE key WHEN 'session_time' THEN value END) AS INTEGER), "
                  "max(CASE key WHEN 'scene' THEN value END) FROM meta",
                  [&](const SqliteStatement& row) {
                    contents.sessionTime = row.integer(0);
                    found.scene = row.text(1);
                    const bool sound = contents.sessionTime >= 0;
                    return sound ? std::string() : "damaged: table meta holds a value out of range";
                  });
  if (!read) return read.error();
  return found;
}

}  // namespace tandem::server
