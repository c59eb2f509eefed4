#include "sync/wire/document_codec.h"

#include <bit>
#include <concepts>
#include <string>

#include "assets/base/printable.h"
#include "assets/document/describe.h"
#include "assets/document/entry_check.h"

namespace tandem::sync {
namespace {

using namespace document;

class EntryWriter {
 public:
  std::vector<std::uint8_t> bytes;

  template <std::unsigned_integral T>
  void number(T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  void real(double value) { number(std::bit_cast<std::uint64_t>(value)); }

  void text(const char*, const std::string& value, std::size_t limit) {
    ASSERT(value.size() <= limit);
    number(static_cast<std::uint16_t>(value.size()));
    for (const char c : value) bytes.push_back(static_cast<std::uint8_t>(c));
  }
  void real(const char*, double value, double, double) { real(value); }
  void vector(const char*, const glm::dvec3& value) {
    for (int i = 0; i < 3; ++i) real(value[i]);
  }
  void pose(const char* name, const Pose& value) {
    vector(name, value.position);
    for (const double x :
         {value.orientation.w, value.orientation.x, value.orientation.y, value.orientation.z})
      real(x);
  }
  void flag(const char*, bool value) { number<std::uint8_t>(value ? 1 : 0); }
  void part(const char*, PartId value, Needed) { number(value); }
  void entry(const char*, EntryId value) { number(value); }
  template <typename E, std::size_t N>
  void choice(const char*, E value, const std::array<const char*, N>&) {
    number(static_cast<std::uint8_t>(value));
  }
  void parts(const char*, const std::vector<PartId>& values, std::size_t) {
    number(static_cast<std::uint16_t>(values.size()));
    for (const PartId value : values) number(value);
  }
  template <typename T>
  void list(const char*, const std::vector<T>& values, std::size_t) {
    number(static_cast<std::uint16_t>(values.size()));
    for (const T& value : values) fields(*this, value);
  }
  template <typename T>
  void addition(const char*, const T& value, bool another) {
    if (value != T{} || another) fields(*this, value);
  }
};

/// Reads what is there; zeros after the end. check() judges the values.
class EntryReader {
 public:
  explicit EntryReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  bool failed() const { return failed_; }
  std::span<const std::uint8_t> rest() const { return bytes_; }

  template <std::unsigned_integral T>
  T number() {
    T value = 0;
    if (!need(sizeof(T))) return value;
    for (std::size_t i = 0; i < sizeof(T); ++i) value = static_cast<T>(value | T{bytes_[i]} << (8 * i));
    bytes_ = bytes_.subspan(sizeof(T));
    return value;
  }
  double real() { return std::bit_cast<double>(number<std::uint64_t>()); }

  void text(const char*, std::string& value, std::size_t limit) {
    const std::size_t size = count(limit, 1);
    value.assign(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(size));
    bytes_ = bytes_.subspan(size);
  }
  void real(const char*, double& value, double, double) { value = real(); }
  void vector(const char*, glm::dvec3& value) {
    for (int i = 0; i < 3; ++i) value[i] = real();
  }
  void pose(const char* name, Pose& value) {
    vector(name, value.position);
    for (double* x : {&value.orientation.w, &value.orientation.x, &value.orientation.y, &value.orientation.z})
      *x = real();
  }
  void flag(const char*, bool& value) {
    const auto byte = number<std::uint8_t>();
    failed_ = failed_ || byte > 1;
    value = byte == 1;
  }
  void part(const char*, PartId& value, Needed) { value = number<PartId>(); }
  void entry(const char*, EntryId& value) { value = number<EntryId>(); }
  template <typename E, std::size_t N>
  void choice(const char*, E& value, const std::array<const char*, N>&) {
    value = static_cast<E>(number<std::uint8_t>());
  }
  void parts(const char*, std::vector<PartId>& values, std::size_t limit) {
    values.resize(count(limit, sizeof(PartId)));
    for (PartId& value : values) value = number<PartId>();
  }
  template <typename T>
  void list(const char*, std::vector<T>& values, std::size_t limit) {
    values.resize(count(limit, 1));
    for (T& value : values) fields(*this, value);
  }
  /// What stands last says something, so that every entry has one encoding.
  template <typename T>
  void addition(const char*, T& value, bool) {
    if (bytes_.empty()) return;
    fields(*this, value);
    failed_ = failed_ || (value == T{} && bytes_.empty());
  }

 private:
  bool need(std::size_t size) {
    if (size <= bytes_.size()) return !failed_;
    failed_ = true;
    bytes_ = {};
    return false;
  }
  /// A count is trusted only as far as the bytes for it are there.
  std::size_t count(std::size_t limit, std::size_t smallest) {
    const std::size_t size = number<std::uint16_t>();
    if (size > limit) failed_ = true;
    return !failed_ && need(size * smallest) ? size : 0;
  }

  std::span<const std::uint8_t> bytes_;
  bool failed_ = false;
};

void write(EntryWriter& writer, const Body& body) {
  writer.number(static_cast<std::uint8_t>(body.index()));
  std::visit([&](const auto& b) { fields(writer, b); }, body);
}

/// Reads a body to the end of the bytes.
Result<Body> read(EntryReader& reader) {
  const std::size_t kind = reader.number<std::uint8_t>();
  if (kind >= std::variant_size_v<Body>) return Error{"an entry is of no known kind"};
  Body body = bodyOfKind(kind);
  std::visit([&](auto& b) { fields(reader, b); }, body);
  if (reader.failed()) return Error{"an entry is cut off or malformed"};
  if (!reader.rest().empty()) return Error{"bytes are left over after an entry"};
  if (const Status sound = check(body); !sound) return sound.error();
  return body;
}

}  // namespace

std::vector<std::uint8_t> encodeBody(const Body& body) {
  EntryWriter writer;
  write(writer, body);
  return std::move(writer.bytes);
}

Result<Body> decodeBody(std::span<const std::uint8_t> bytes) {
  EntryReader reader(bytes);
  return read(reader);
}

std::vector<std::uint8_t> encodeEntry(const Entry& entry) {
  EntryWriter writer;
  writer.number(entry.id);
  writer.number(entry.revision);
  writer.number(entry.author);
  writer.number(entry.creation);
  writer.text("author", entry.authorName, kMaxName);
  writer.number(static_cast<std::uint64_t>(entry.made));
  writer.number(entry.editor);
  writer.number(entry.request);
  writer.number(static_cast<std::uint64_t>(entry.changed));
  write(writer, entry.body);
  return std::move(writer.bytes);
}

Result<Entry> decodeEntry(std::span<const std::uint8_t> bytes) {
  EntryReader reader(bytes);
  Entry entry;
  entry.id = reader.number<EntryId>();
  entry.revision = reader.number<Revision>();
  entry.author = reader.number<SiteId>();
  entry.creation = reader.number<std::uint32_t>();
  reader.text("author", entry.authorName, kMaxName);
  entry.made = static_cast<std::int64_t>(reader.number<std::uint64_t>());
  entry.editor = reader.number<SiteId>();
  entry.request = reader.number<std::uint32_t>();
  entry.changed = static_cast<std::int64_t>(reader.number<std::uint64_t>());
  if (entry.id == 0 || entry.revision == 0) return Error{"an entry has no id or no revision"};
  // The largest values are kept free, so that counting on from one cannot overflow.
  if (entry.id >> 63 != 0 || entry.revision >> 63 != 0)
    return Error{"an entry's id or revision is too large"};
  if (!isPrintable(entry.authorName)) return Error{"an author's name is not printable UTF-8"};
  Result<Body> body = read(reader);
  if (!body) return body.error();
  entry.body = std::move(*body);
  return entry;
}

}  // namespace tandem::sync
