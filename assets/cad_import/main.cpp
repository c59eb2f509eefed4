// tandem-import: makes a glTF scene of a CAD file. The libraries that read CAD crash, hang and take memory on
// damaged files, so the program runs itself again with limits, and keeps what that leaves only if it is
// whole. Exit codes: 0 done, 1 the result cannot be written, 2 bad arguments or input (one line on standard
// error).

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <new>
#include <string>

#include <unistd.h>

#include "assets/base/command_line.h"
#include "assets/base/json.h"
#include "assets/base/limited_process.h"
#include "assets/cad_import/import_file.h"
#include "assets/cad_import/length_unit.h"
#include "assets/cad_import/report.h"
#include "assets/cad_import/write_glb.h"

namespace tandem::cad_import {
namespace {

constexpr int kDone = 0, kFailed = 1, kBadInput = 2;

constexpr const char* kExamples = R"(Examples:
  tandem-import gearbox.step -o gearbox.glb
      Solids become parts with their names, colours and places; what is said beside is worth reading.
  tandem-import bracket.stl --units mm -o bracket.glb
      A mesh has no unit of its own.
  tandem-import gearbox.step --deflection 0.00002 -o fine.glb
      Facets at most 20 um off the surface; by default a thousandth of each solid's size.
  tandem check gearbox.glb --clash
      What overlaps in the result.

STEP files are taken as z-up and turned; --y-up leaves them. Exact surfaces, materials, densities and
tolerances stand in extras.cad of the result. A damaged file costs at most the time and memory of
--limit-seconds and --limit-memory, and leaves no result.)";

struct Options {
  std::string input, output;
  ImportOptions import;
  bool json = false, progress = false, worker = false;
  std::int64_t seconds = 600, memory = 4096;  // of the processor; MiB
};

int failed(int code, std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, '_');
  std::fprintf(stderr, "tandem-import: %s\n", text.c_str());
  return code;
}

void addOptions(assets::CommandLine& app, Options& options) {
  app.option("file", options.input, "the CAD file: .step, .stp, .3mf, .stl, .obj or .ply")
      .typeName("FILE")
      .required();
  app.option("-o,--output", options.output, "the scene that is written, .glb").typeName("OUT.glb").required();
  app.option("--units", options.import.units,
             "what one unit of the file is: m, cm, mm, inch, foot; by default as the file says, of a mesh m");
  app.option("--deflection", options.import.deflection, "how far facets may be off the surface, m")
      .typeName("M")
      .numberFrom(1e-9, 1e3);
  app.flag("--y-up", options.import.yUp, "the file's y points up, as in glTF");
  app.flag("--json", options.json, "the report as JSON");
  app.flag("--progress", options.progress, "a line \"progress SHARE WHAT\" on standard output now and then");
  app.option("--limit-seconds", options.seconds, "processor time, s").integerFrom(1, 86400).showDefault();
  app.option("--limit-memory", options.memory, "address space, MiB").integerFrom(256, 1 << 20).showDefault();
  app.flag("--in-this-process", options.worker, "without limits; a damaged file may crash it");
  app.footer(kExamples);
}

/// What may be half written until the import is done.
std::string partOf(const Options& options) { return options.output + ".part"; }

void removeFile(const std::string& path) {
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
}

/// The import itself. Standard output has lines of progress, then the report.
int work(Options& options) {
  options.import.progress = [last = -1.0](double share, const char* what) mutable {
    if (share - last < 0.01) return;
    last = share;
    std::printf("progress %.3f %s\n", share, what);
    std::fflush(stdout);
  };
  try {
    ImportFigures figures;
    const Result<CadScene> scene = importFile(options.input, options.import, figures);
    if (!scene) return failed(kBadInput, options.input + ": " + scene.error().message);
    const std::string bytes = toGlb(*scene);
    std::ofstream file(partOf(options), std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!file.flush()) return failed(kFailed, options.output + ": cannot be written");
    std::printf("report %s\n", reportOf(*scene, figures).dump().c_str());
    return std::fflush(stdout) == 0 ? kDone : kFailed;
  } catch (const std::bad_alloc&) {
    return failed(kBadInput, options.input + ": there is not enough memory for it (--limit-memory)");
  } catch (const std::exception& error) {
    return failed(kBadInput, options.input + ": " + error.what());
  }
}

std::string reasonOf(const Options& options, const ProcessEnd& end) {
  const std::string damaged = options.input + ": ";
  switch (end.how) {
    case ProcessEnd::How::tookTooLong:
      return damaged + "not done in " + std::to_string(options.seconds) +
             " s of processor time (--limit-seconds)";
    case ProcessEnd::How::crashed:
      if (end.code == SIGXFSZ) return damaged + "the result is too large";
      return damaged + "the reader crashed on it; the file is damaged, or needs more memory (--limit-memory)";
    default:
      return damaged + "the reader ended without a result";
  }
}

/// The arguments of this program again, for the process with limits.
std::vector<std::string> again(int argc, char** argv) {
  std::vector<std::string> command{"/proc/self/exe"};
  command.insert(command.end(), argv + 1, argv + argc);
  command.emplace_back("--in-this-process");
  return command;
}

int supervise(const Options& options, int argc, char** argv) {
  ProcessLimits limits;
  limits.memory = static_cast<std::uint64_t>(options.memory) << 20;
  limits.processorTime = static_cast<double>(options.seconds);
  limits.wallTime = 2.0 * limits.processorTime + 60.0;
  const bool bar = ::isatty(STDERR_FILENO) == 1 && !options.progress;
  std::string report;
  const auto onLine = [&](const std::string& line) {
    double share = 0.0;
    char what[32] = "";
    if (line.rfind("report ", 0) == 0) report = line.substr(7);
    if (std::sscanf(line.c_str(), "progress %lf %31[a-z ]", &share, what) != 2) return;
    if (options.progress) std::printf("%s\n", line.c_str()), std::fflush(stdout);
    if (bar) std::fprintf(stderr, "\r\033[Kimporting %3.0f %% %s", 100.0 * share, what);
  };
  const Result<ProcessEnd> end = runLimited(again(argc, argv), limits, onLine);
  if (bar) std::fputs("\r\033[K", stderr);
  if (!end) return failed(kFailed, end.error().message);
  const std::string part = partOf(options);
  if (end->how != ProcessEnd::How::exited || end->code != kDone || report.empty()) {
    removeFile(part);
    const bool said = end->how == ProcessEnd::How::exited &&
                      (end->code == kFailed || end->code == kBadInput) &&
                      end->lastError.rfind("tandem-import: ", 0) == 0;
    if (!said) return failed(kBadInput, reasonOf(options, *end));
    return failed(end->code, end->lastError.substr(15));
  }
  const Result<Json> understood = Json::parse(report);
  std::error_code error;
  std::filesystem::rename(part, options.output, error);
  if (error || !understood) {
    removeFile(part);
    return failed(kFailed, options.output + ": cannot be written");
  }
  const std::string text = options.json ? understood->dump(2) + "\n" : inWords(*understood, options.output);
  return std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0 ? kDone : kFailed;
}

}  // namespace
}  // namespace tandem::cad_import

int main(int argc, char** argv) {
  using namespace tandem::cad_import;
  Options options;
  tandem::assets::CommandLine app("Makes a glTF scene of a CAD file.", TANDEM_VERSION);
  addOptions(app, options);
  if (const std::optional<int> code = app.parse("tandem-import", argc, argv)) return *code;
  if (!options.import.units.empty() && !metresPerUnit(options.import.units))
    return failed(kBadInput, "--units " + options.import.units + ": must be m, cm, mm, inch or foot");
  return options.worker ? work(options) : supervise(options, argc, argv);
}
