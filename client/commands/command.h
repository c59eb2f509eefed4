#pragma once

// The sub-commands of `tandem`, one a file. Each adds its options to the command line and, when it runs, sets
// the exit code: 0 done, 1 the run failed or a bound was broken, 2 bad arguments or input.

#include <chrono>
#include <string>

#include "assets/base/command_line.h"
#include "assets/base/result.h"
#include "assets/gltf/load_gltf.h"

namespace tandem::haptics {
class ContactScene;
}

namespace tandem::client {

inline constexpr int kExitDone = 0, kExitFailed = 1, kExitBadInput = 2;

void addJoin(assets::CommandLine& program, int& exitCode);
void addCheck(assets::CommandLine& program, int& exitCode);
void addProbe(assets::CommandLine& program, int& exitCode);
void addSimulate(assets::CommandLine& program, int& exitCode);
void addDevices(assets::CommandLine& program, int& exitCode);
void addReplay(assets::CommandLine& program, int& exitCode);
void addReport(assets::CommandLine& program, int& exitCode);
void addDocument(assets::CommandLine& program, int& exitCode);
void addExtract(assets::CommandLine& program, int& exitCode);

/// Prints one line on stderr and returns kExitBadInput.
int badInput(const Error& error);

/// The options of reading a scene, shared by the commands that load one from a file.
struct SceneArguments {
  std::string path;
  std::string units = "m";
  std::vector<std::string> movable;
  bool noCache = false;
  std::int64_t maxJson = std::int64_t(assets::LoadOptions{}.maxJsonBytes >> 20);  // MiB
  bool facets = false;  // the file's normals are not felt
};
void addSceneOptions(assets::CommandLine& command, SceneArguments& arguments);
Result<assets::LoadOptions> loadOptions(const SceneArguments& arguments);
/// Loads the scene through the user's cache, with a progress bar if stderr is a terminal.
Result<assets::Scene> loadScene(const SceneArguments& arguments);

/// Shows the progress of a task on stderr once it takes longer than half a second. A terminal gets one line
/// that is redrawn; elsewhere nothing is printed, or one line with the name of the task if `named`.
class ProgressLine {
 public:
  explicit ProgressLine(bool named = false);
  ~ProgressLine();  // clears a terminal's line
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  void show(double done, const char* what);  // done: 0..1

 private:
  bool named_;
  std::chrono::steady_clock::time_point start_;
  std::string what_;    // the task as last shown; empty before
  double done_ = -1.0;  // as last shown
};

/// Makes the models by which a part in the hand collides, through the user's cache, with a ProgressLine.
void modelParts(haptics::ContactScene& contact, bool noCache);

/// A number as help and tables show it: up to six digits, no trailing zeros.
std::string inShort(double value);

/// Checks whether a file can be written there, so that a run does not lose its result. An empty path is fine.
Status writable(const std::string& path);

/// Writes text to a file; the error gives the reason.
Status writeFile(const std::string& path, const std::string& text);

}  // namespace tandem::client
