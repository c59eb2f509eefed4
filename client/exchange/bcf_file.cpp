#include "client/exchange/bcf_file.h"

#include <zip.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <memory>
#include <set>
#include <utility>

#include "assets/base/assert.h"
#include "assets/base/printable.h"
#include "client/exchange/bcf_reader.h"
#include "client/exchange/bcf_writer.h"
#include "client/exchange/guid.h"

namespace tandem::client {
namespace {

constexpr const char* kVersionFile = "bcf.version";
constexpr const char* kMarkupFile = "/markup.bcf";

using Archive = std::unique_ptr<zip_t, decltype(&zip_discard)>;

std::string reasonOf(zip_error_t& error) {
  std::string reason = zip_error_strerror(&error);
  zip_error_fini(&error);
  return reason;
}

/// Adds files to an archive; their bytes live until close().
class ArchiveWriter {
 public:
  explicit ArchiveWriter(std::string path) : path_(std::move(path)) {
    int code = 0;
    archive_.reset(zip_open(path_.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code));
    if (archive_) return;
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    reason_ = reasonOf(error);
  }

  void add(const std::string& name, const void* bytes, std::size_t size, bool compress = true) {
    if (!reason_.empty()) return;
    zip_source_t* source = zip_source_buffer(archive_.get(), bytes, size, 0);
    const zip_int64_t index =
        source == nullptr ? -1 : zip_file_add(archive_.get(), name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0) {
      if (source != nullptr) zip_source_free(source);
      reason_ = zip_strerror(archive_.get());
      return;
    }
    // A fixed time, so that the same topics make the same archive; zip knows none before 1980.
    constexpr std::time_t kFirstOfZip = 315532800;
    const auto file = static_cast<zip_uint64_t>(index);
    zip_file_set_mtime(archive_.get(), file, kFirstOfZip, 0);
    if (!compress) zip_set_file_compression(archive_.get(), file, ZIP_CM_STORE, 0);
  }
  void add(const std::string& name, std::string text) {
    texts_.push_back(std::make_unique<std::string>(std::move(text)));
    add(name, texts_.back()->data(), texts_.back()->size());
  }

  Status close() {
    if (reason_.empty() && zip_close(archive_.get()) == 0)
      static_cast<void>(archive_.release());  // closing frees it
    else if (reason_.empty())
      reason_ = zip_strerror(archive_.get());
    if (reason_.empty()) return {};
    return Error{path_ + ": cannot be written: " + reason_};
  }

 private:
  std::string path_, reason_;
  std::vector<std::unique_ptr<std::string>> texts_;
  Archive archive_{nullptr, &zip_discard};
};

/// Whether a name stays within the archive's folder wherever it is unpacked.
bool isHarmless(const std::string& name) {
  if (name.empty() || name.front() == '/' || name.find_first_of("\\:") != std::string::npos) return false;
  if (!isPrintable(name)) return false;
  const std::string inside = '/' + name + '/';
  return inside.find("/../") == std::string::npos && inside.find("/./") == std::string::npos;
}

class ArchiveReader {
 public:
  /// `bytes` outlive this.
  static Result<ArchiveReader> open(std::span<const std::byte> bytes) {
    if (bytes.size() > kMaxBcfBytes) return Error{"is larger than 256 MiB"};
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
    if (source == nullptr) return Error{reasonOf(error)};
    ArchiveReader reader;
    reader.archive_.reset(zip_open_from_source(source, ZIP_RDONLY, &error));
    if (!reader.archive_) {
      zip_source_free(source);
      return Error{"is no BCF archive: " + reasonOf(error)};
    }
    zip_error_fini(&error);
    if (Status listed = reader.list(); !listed) return listed.error();
    return reader;
  }

  const std::set<std::string>& names() const { return names_; }

  /// A file's bytes, unpacked until there are too many.
  Result<std::string> read(const std::string& name) {
    using File = std::unique_ptr<zip_file_t, decltype(&zip_fclose)>;
    const File file(zip_fopen(archive_.get(), name.c_str(), 0), &zip_fclose);
    if (!file) return Error{name + ": " + zip_strerror(archive_.get())};
    std::string text;
    for (;;) {
      constexpr std::size_t kBlock = std::size_t{64} << 10;
      const std::size_t begin = text.size();
      text.resize(begin + kBlock);
      const zip_int64_t count = zip_fread(file.get(), text.data() + begin, kBlock);
      if (count < 0) return Error{name + ": " + zip_file_strerror(file.get())};
      text.resize(begin + static_cast<std::size_t>(count));
      if (text.size() > kMaxXmlBytes) return Error{name + ": is larger than 4 MiB"};
      if (count == 0) break;
    }
    total_ += text.size();
    if (total_ > kMaxXmlTotal) return Error{"holds more than 128 MiB of topics"};
    return text;
  }

 private:
  ArchiveReader() = default;

  Status list() {
    const zip_int64_t count = zip_get_num_entries(archive_.get(), 0);
    if (count < 0 || static_cast<std::size_t>(count) > kMaxBcfEntries) return Error{"holds too many files"};
    for (zip_int64_t i = 0; i < count; ++i) {
      const char* name = zip_get_name(archive_.get(), static_cast<zip_uint64_t>(i), ZIP_FL_ENC_GUESS);
      if (name == nullptr || !isHarmless(name)) return Error{"holds a file whose name leads out of it"};
      if (!names_.insert(name).second) return Error{"holds a file twice: " + std::string(name)};
    }
    return {};
  }

  Archive archive_{nullptr, &zip_discard};
  std::set<std::string> names_;
  std::size_t total_ = 0;  // bytes that were unpacked
};

Error at(const std::string& file, const Error& error) { return Error{file + ": " + error.message}; }

Result<Topic> readTopic(ArchiveReader& archive, const std::string& folder, BcfVersion version) {
  const std::string markupFile = folder + kMarkupFile;
  const Result<std::string> xml = archive.read(markupFile);
  if (!xml) return xml.error();
  Result<BcfMarkup> markup = readBcfMarkup(*xml, version);
  if (!markup) return at(markupFile, markup.error());
  std::string viewpoint = markup->viewpointFile;
  if (viewpoint.empty() && archive.names().contains(folder + '/' + kViewpointFile))
    viewpoint = kViewpointFile;
  if (viewpoint.empty()) return std::move(markup->topic);
  viewpoint = folder + '/' + viewpoint;
  if (!archive.names().contains(viewpoint))
    return at(markupFile, Error{"names a viewpoint that is not there"});
  const Result<std::string> viewXml = archive.read(viewpoint);
  if (!viewXml) return viewXml.error();
  Result<std::optional<TopicView>> view = readBcfViewpoint(*viewXml);
  if (!view) return at(viewpoint, view.error());
  markup->topic.view = std::move(*view);
  return std::move(markup->topic);
}

Result<std::vector<Topic>> readTopics(ArchiveReader& archive) {
  if (!archive.names().contains(kVersionFile)) return Error{"is no BCF archive: it has no bcf.version"};
  const Result<std::string> versionXml = archive.read(kVersionFile);
  if (!versionXml) return versionXml.error();
  const Result<BcfVersion> version = readBcfVersion(*versionXml);
  if (!version) return at(kVersionFile, version.error());
  std::vector<Topic> topics;
  std::set<std::string> guids;
  std::size_t comments = 0;
  for (const std::string& name : archive.names()) {
    const std::size_t slash = name.find('/');
    if (slash == std::string::npos || name.substr(slash) != kMarkupFile) continue;
    Result<Topic> topic = readTopic(archive, name.substr(0, slash), *version);
    if (!topic) return topic.error();
    if (!guids.insert(topic->guid).second) return at(name, Error{"is a second topic of its GUID"});
    comments += topic->comments.size();
    topics.push_back(std::move(*topic));
    if (topics.size() > kMaxBcfTopics || comments > kMaxBcfComments) return Error{"holds too many topics"};
  }
  return topics;
}

}  // namespace

Status writeBcf(const std::string& path, const std::vector<Topic>& topics, BcfVersion version,
                const std::string& project, const std::string& sceneHash) {
  ArchiveWriter archive(path);
  archive.add(kVersionFile, bcfVersionXml(version));
  if (version == BcfVersion::v3_0) {
    archive.add("project.bcfp", bcfProjectXml(uuidOf("project\n" + sceneHash), project));
    archive.add("extensions.xml", bcfExtensionsXml(topics));
  }
  for (const Topic& topic : topics) {
    archive.add(topic.guid + kMarkupFile, bcfMarkupXml(topic, version));
    if (!topic.view) continue;
    const std::string folder = topic.guid + '/';
    archive.add(folder + kViewpointFile, bcfViewpointXml(*topic.view, version));
    if (!topic.picture.empty())
      archive.add(folder + kSnapshotFile, topic.picture.data(), topic.picture.size(), false);
  }
  return archive.close();
}

Result<std::vector<Topic>> readBcf(std::span<const std::byte> archive, const std::string& source) {
  Result<ArchiveReader> reader = ArchiveReader::open(archive);
  if (!reader) return at(source, reader.error());
  Result<std::vector<Topic>> topics = readTopics(*reader);
  if (!topics) return at(source, topics.error());
  return topics;
}

Result<std::vector<Topic>> readBcf(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return Error{path + ": no such file, or it cannot be read"};
  const std::streamoff size = file.tellg();
  if (size < 0) return Error{path + ": cannot be read"};
  if (static_cast<std::uint64_t>(size) > kMaxBcfBytes) return Error{path + ": is larger than 256 MiB"};
  std::vector<std::byte> bytes(static_cast<std::size_t>(size));
  file.seekg(0);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), size)) return Error{path + ": cannot be read"};
  return readBcf(bytes, path);
}

}  // namespace tandem::client
