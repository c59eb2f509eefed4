// tandem: one site of a session, and the tools beside it.

#include <algorithm>
#include <csignal>
#include <string>
#include <vector>

#include "assets/scene/near_names.h"
#include "client/commands/command.h"

namespace {

/// Says so of a first word that is no command.
bool unknownCommand(const tandem::assets::CommandLine& program, const std::string& word) {
  const std::vector<std::string> names = program.commandNames();
  if (word.empty() || word[0] == '-' || std::find(names.begin(), names.end(), word) != names.end())
    return false;
  const std::string meant = tandem::assets::meantName(word, names);
  tandem::client::badInput(tandem::Error{
      "unknown command " + word + (meant.empty() ? " (see --help)" : "; did you mean " + meant + "?")});
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its limit is a failed write, like a full disk
  tandem::assets::CommandLine program(
      "Tandem: several people, each at their own site, put their hands on one CAD scene and feel it.",
      TANDEM_VERSION);
  program.footer(
      "A first session:\n"
      "  tandem-server assets/scenes/pump.glb     prints one join link a role\n"
      "  tandem join LINK                         in another terminal, for each person\n"
      "Every command explains itself: tandem COMMAND --help");
  int exitCode = tandem::client::kExitDone;
  tandem::client::addJoin(program, exitCode);
  tandem::client::addCheck(program, exitCode);
  tandem::client::addProbe(program, exitCode);
  tandem::client::addExtract(program, exitCode);
  tandem::client::addSimulate(program, exitCode);
  tandem::client::addDevices(program, exitCode);
  tandem::client::addReplay(program, exitCode);
  tandem::client::addReport(program, exitCode);
  tandem::client::addDocument(program, exitCode);
  if (argc > 1 && unknownCommand(program, argv[1])) return tandem::client::kExitBadInput;
  return program.parse("tandem", argc, argv).value_or(exitCode);
}
