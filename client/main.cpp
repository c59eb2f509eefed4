// tandem: one site of a session, and the tools beside it.

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "assets/scene/near_names.h"
#include "client/commands/command.h"

namespace {

/// Says so of a first word that is no command.
bool unknownCommand(const CLI::App& app, const std::string& word) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
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
  CLI::App app{
      "Tandem: several people, each at their own site, put their hands on one CAD scene and feel it."};
  app.set_version_flag("--version", TANDEM_VERSION);
  app.require_subcommand(1);
  app.footer(
      "A first session:\n"
      "  tandem-server assets/scenes/pump.glb     prints one join link a role\n"
      "  tandem join LINK                         in another terminal, for each person\n"
      "Every command explains itself: tandem COMMAND --help");
  int exitCode = tandem::client::kExitDone;
  tandem::client::addJoin(app, exitCode);
  tandem::client::addCheck(app, exitCode);
  tandem::client::addProbe(app, exitCode);
  tandem::client::addSimulate(app, exitCode);
  tandem::client::addDevices(app, exitCode);
  tandem::client::addReplay(app, exitCode);
  tandem::client::addReport(app, exitCode);
  if (argc > 1 && unknownCommand(app, argv[1])) return tandem::client::kExitBadInput;
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "tandem: %s (see --help)\n", error.what());
    return tandem::client::kExitBadInput;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tandem: %s\n", error.what());
    return tandem::client::kExitFailed;
  }
  return exitCode;
}
