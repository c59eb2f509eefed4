#include "assets/document/document_json.h"

#include <algorithm>
#include <cstring>

#include "assets/base/json.h"
#include "assets/base/printable.h"
#include "assets/document/describe.h"
#include "assets/document/entry_check.h"

namespace tandem::document {
namespace {

constexpr std::int64_t kLatest = std::int64_t{1} << 53;  // Unix time; JSON keeps such numbers exactly

Json vectorToJson(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

/// Adds the fields of a record to an object.
class JsonWriter {
 public:
  explicit JsonWriter(Json& object) : object_(object) {}

  void text(const char* name, const std::string& value, std::size_t) { object_[name] = value; }
  void real(const char* name, double value, double, double) { object_[name] = value; }
  void vector(const char* name, const glm::dvec3& value) { object_[name] = vectorToJson(value); }
  void pose(const char* name, const Pose& value) {
    const glm::dquat& q = value.orientation;
    object_[name]["position_m"] = vectorToJson(value.position);
    object_[name]["orientation_wxyz"] = {q.w, q.x, q.y, q.z};
  }
  void flag(const char* name, bool value) { object_[name] = value; }
  void part(const char* name, PartId value, Needed) {
    object_[name] = value == kNoPart ? Json(nullptr) : Json(value);
  }
  void entry(const char* name, EntryId value) { object_[name] = value; }
  template <typename E, std::size_t N>
  void choice(const char* name, E value, const std::array<const char*, N>& names) {
    object_[name] = names[static_cast<std::size_t>(value)];
  }
  void parts(const char* name, const std::vector<PartId>& values, std::size_t) { object_[name] = values; }
  template <typename T>
  void list(const char* name, const std::vector<T>& values, std::size_t) {
    Json elements = Json::array();
    for (const T& value : values) {
      elements.push(Json::object());
      JsonWriter writer(elements.back());
      fields(writer, value);
    }
    object_[name] = std::move(elements);
  }
  template <typename T>
  void addition(const char* name, const T& value, bool) {
    if (value == T{}) return;
    object_[name] = Json::object();
    JsonWriter writer(object_[name]);
    fields(writer, value);
  }

 private:
  Json& object_;
};

/// Reads the fields of a record. Throws JsonError for what is missing, of another kind, or not known.
class JsonReader {
 public:
  explicit JsonReader(const Json& object) : object_(object) {
    if (!object.isObject()) throw JsonError("is not an object");
  }
  /// After all fields: whether the object has members that nobody asked for.
  void finish() const {
    for (const auto& [name, value] : object_.members())
      if (std::find(read_.begin(), read_.end(), name) == read_.end())
        throw JsonError("has an unknown member '" + printable(name, 64) + "'");
  }
  const Json& at(const char* name) {
    read_.push_back(name);
    return object_.at(name);
  }
  std::int64_t time(const char* name) {
    const std::uint64_t value = natural(at(name), name);
    if (value > static_cast<std::uint64_t>(kLatest)) throw JsonError(std::string(name) + " is out of range");
    return static_cast<std::int64_t>(value);
  }

  void text(const char* name, std::string& value, std::size_t) { value = at(name).text(); }
  void real(const char* name, double& value, double, double) { value = at(name).number(); }
  void vector(const char* name, glm::dvec3& value) {
    const Json& json = numbers(at(name), name, 3);
    value = {json.at(0).number(), json.at(1).number(), json.at(2).number()};
  }
  void pose(const char* name, Pose& value) {
    JsonReader reader(at(name));
    reader.vector("position_m", value.position);
    const Json& json = numbers(reader.at("orientation_wxyz"), name, 4);
    value.orientation =
        glm::dquat(json.at(0).number(), json.at(1).number(), json.at(2).number(), json.at(3).number());
    reader.finish();
  }
  void flag(const char* name, bool& value) { value = at(name).boolean(); }
  void part(const char* name, PartId& value, Needed) {
    const Json& json = at(name);
    value = json.isNull() ? kNoPart : partOf(json, name);
  }
  void entry(const char* name, EntryId& value) { value = natural(at(name), name); }
  template <typename E, std::size_t N>
  void choice(const char* name, E& value, const std::array<const char*, N>& names) {
    const std::string& text = at(name).text();
    const auto found =
        std::find_if(names.begin(), names.end(), [&](const char* each) { return text == each; });
    if (found == names.end()) throw JsonError(std::string(name) + " is none of its values");
    value = static_cast<E>(found - names.begin());
  }
  void parts(const char* name, std::vector<PartId>& values, std::size_t limit) {
    for (const Json& json : elements(name, limit)) values.push_back(partOf(json, name));
  }
  template <typename T>
  void list(const char* name, std::vector<T>& values, std::size_t limit) {
    for (const Json& json : elements(name, limit)) {
      JsonReader reader(json);
      fields(reader, values.emplace_back());
      reader.finish();
    }
  }
  template <typename T>
  void addition(const char* name, T& value, bool) {
    if (!object_.contains(name)) return;
    JsonReader reader(at(name));
    fields(reader, value);
    reader.finish();
  }

 private:
  static std::uint64_t natural(const Json& json, const char* name) {
    if (!json.isNatural()) throw JsonError(std::string(name) + " is not a whole number");
    return json.integer();
  }
  static PartId partOf(const Json& json, const char* name) {
    const std::uint64_t value = natural(json, name);
    if (value >= kMaxParts) throw JsonError(std::string(name) + " is no part");
    return static_cast<PartId>(value);
  }
  static const Json& numbers(const Json& json, const char* name, std::size_t count) {
    if (!json.isArray() || json.size() != count)
      throw JsonError(std::string(name) + " does not have " + std::to_string(count) + " numbers");
    return json;
  }
  const Json& elements(const char* name, std::size_t limit) {
    const Json& json = at(name);
    if (!json.isArray() || json.size() > limit)
      throw JsonError(std::string(name) + " is no list, or too long");
    return json;
  }

  const Json& object_;
  std::vector<std::string> read_;
};

Entry readEntry(const Json& json) {
  JsonReader reader(json);
  Entry entry;
  entry.id = reader.at("id").integer();
  if (entry.id == 0) throw JsonError("has no id");
  entry.authorName = reader.at("author").text();
  if (entry.authorName.size() > kMaxName || !isPrintable(entry.authorName))
    throw JsonError("has an author whose name is too long or cannot be shown");
  entry.made = reader.time("made");
  entry.changed = reader.time("changed");
  const std::string& kind = reader.at("kind").text();
  const auto known =
      std::find_if(kKindNames.begin() + 1, kKindNames.end(), [&](const char* name) { return kind == name; });
  if (known == kKindNames.end()) throw JsonError("is of no known kind");
  entry.body = bodyOfKind(static_cast<std::size_t>(known - kKindNames.begin()));
  std::visit([&](auto& body) { fields(reader, body); }, entry.body);
  reader.finish();
  if (const Status sound = check(entry.body); !sound) throw JsonError(sound.error().message);
  return entry;
}

/// Whether every entry has an id of its own, and refers to a note of the file.
void checkReferences(const std::vector<Entry>& entries) {
  std::map<EntryId, bool> isNote;
  for (const Entry& entry : entries)
    if (!isNote.emplace(entry.id, std::holds_alternative<Note>(entry.body)).second)
      throw JsonError("entry " + std::to_string(entry.id) + " is there twice");
  for (const Entry& entry : entries) {
    const EntryId note = reference(entry.body);
    const auto found = isNote.find(note);
    if (note != 0 && (found == isNote.end() || !found->second))
      throw JsonError("entry " + std::to_string(entry.id) + " refers to no note of the file");
  }
}

DocumentFile readFile(const Json& json) {
  JsonReader reader(json);
  if (reader.at("tandem_document").integer() != 1) throw JsonError("is of an unknown version");
  DocumentFile file;
  file.scene = reader.at("scene").text();
  const Json& entries = reader.at("entries");
  reader.finish();
  if (!entries.isArray() || entries.size() > kMaxEntries) throw JsonError("entries is no list, or too long");
  file.entries.reserve(entries.size());
  for (const Json& each : entries) {
    try {
      file.entries.push_back(readEntry(each));
    } catch (const JsonError& error) {
      throw JsonError("entries[" + std::to_string(file.entries.size()) + "]: " + error.what());
    }
  }
  checkReferences(file.entries);
  std::stable_partition(file.entries.begin(), file.entries.end(),
                        [](const Entry& entry) { return reference(entry.body) == 0; });
  return file;
}

}  // namespace

std::string toJson(const Document& document, const std::string& scene) {
  std::string text = "{\"tandem_document\": 1, \"scene\": " + Json(scene).dump() + ", \"entries\": [";
  const char* separator = "\n";
  for (const auto& [id, entry] : document.entries()) {
    if (entry.removed()) continue;
    Json json = {{"id", id},
                 {"kind", kKindNames[entry.body.index()]},
                 {"author", entry.authorName},
                 {"made", static_cast<std::uint64_t>(entry.made)},
                 {"changed", static_cast<std::uint64_t>(entry.changed)}};
    JsonWriter writer(json);
    std::visit([&](const auto& body) { fields(writer, body); }, entry.body);
    text += separator + json.dump();
    separator = ",\n";
  }
  return text + "\n]}\n";
}

Result<DocumentFile> fromJson(const std::string& text, const std::string& source) {
  if (text.size() > kMaxFileBytes) return Error{source + ": larger than a document may be"};
  const Result<Json> json = Json::parse(text);
  if (!json) return Error{source + ": " + json.error().message};
  try {
    return readFile(*json);
  } catch (const JsonError& error) {
    return Error{source + ": " + error.what()};
  }
}

}  // namespace tandem::document
