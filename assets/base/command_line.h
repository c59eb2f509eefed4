#pragma once

// The command line of a program: options, flags and sub-commands, each with the help that it prints. The only
// unit that knows CLI11, whose headers cost seconds to compile.
//
// Errors go to stderr as one line, "PROGRAM: what is wrong (see --help)".

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace tandem::assets {

/// One option, to be refined where it is added. A handle: copies mean the same option.
class CommandLineOption {
 public:
  explicit CommandLineOption(CLI::Option* option) : option_(option) {}

  CommandLineOption& required();
  /// Sets the word that --help shows for the value, instead of its type.
  CommandLineOption& typeName(const std::string& name);
  /// Makes --help show the variable's present value as the default.
  CommandLineOption& showDefault();
  /// Takes one value each time that the option is given.
  CommandLineOption& oneValue();
  CommandLineOption& values(int count);
  /// Accepts numbers from `min` to `max` only, and never nan.
  CommandLineOption& numberFrom(double min, double max);
  /// Accepts whole numbers from `min` to `max` only; --help shows the range.
  CommandLineOption& integerFrom(int min, int max);
  /// Accepts the option only together with the other one.
  CommandLineOption& needs(const CommandLineOption& other);
  CommandLineOption& needs(const std::string& other);
  CommandLineOption& excludes(const CommandLineOption& other);

 private:
  CLI::Option* option_;
};

/// A program's command line, or one of its sub-commands. A handle: copies mean the same command line. Every
/// variable given to it must live until parse() returns.
class CommandLine {
 public:
  /// The command line of a program; --version prints `version`.
  CommandLine(const std::string& description, const std::string& version);

  /// Adds a sub-command. A program with sub-commands requires one of them.
  CommandLine command(const std::string& name, const std::string& description);
  std::vector<std::string> commandNames() const;

  /// Adds an option; the value that the variable has is its default. "name" is a positional argument,
  /// "--name" an option.
  CommandLineOption option(const std::string& name, std::string& value, const std::string& help);
  CommandLineOption option(const std::string& name, int& value, const std::string& help);
  CommandLineOption option(const std::string& name, double& value, const std::string& help);
  CommandLineOption option(const std::string& name, std::int64_t& value, const std::string& help);
  CommandLineOption option(const std::string& name, std::uint64_t& value, const std::string& help);
  CommandLineOption option(const std::string& name, std::vector<std::string>& value, const std::string& help);
  CommandLineOption flag(const std::string& name, bool& value, const std::string& help);

  /// Sets the text at the end of --help.
  void footer(const std::string& text);
  /// Sets the function that parse() calls for this sub-command.
  void onRun(std::function<void()> run);

  /// Reads the arguments into the variables and runs the sub-command. Returns the exit code where the program
  /// is to end now: 0 after --help or --version, 2 after wrong arguments, 1 if a sub-command threw; else
  /// nothing.
  std::optional<int> parse(const std::string& program, int argc, char** argv);

 private:
  CommandLine(std::shared_ptr<CLI::App> root, CLI::App* app);

  std::shared_ptr<CLI::App> root_;  // the program's, which owns its sub-commands
  CLI::App* app_;
};

}  // namespace tandem::assets
