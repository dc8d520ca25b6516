// What the command line knows, for cmake/completion.py and cmake/man_pages.py: one line for each
// command and option, from the parser itself. Fields are separated by tabs:
//
//   command  <path>                  <summary>             path: "patchdb create"; "": the program
//   option   <path>  <name>          <kind>  <description>
//
// kind: flag, value, or the values that there are, separated by blanks.
#include <CLI/CLI.hpp>
#include <iostream>
#include <string>

#include "tools/commands/commands.h"

namespace {

// In one line, without tabs.
std::string Plain(std::string text) {
  for (char& character : text)
    if (character == '\n' || character == '\t') character = ' ';
  return text;
}

// "{auto,positive,negative}" in an option's type name lists its values.
std::string KindOf(const CLI::Option& option) {
  if (option.get_items_expected_max() == 0) return "flag";
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find('{'), end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return "value";
  std::string values = type.substr(begin + 1, end - begin - 1);
  for (char& character : values)
    if (character == ',') character = ' ';
  return values;
}

void Print(const CLI::App& app, const std::string& path) {
  std::cout << "command\t" << path << "\t" << Plain(app.get_description()) << "\n";
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames())
      std::cout << "option\t" << path << "\t--" << name << "\t" << KindOf(*option) << "\t"
                << Plain(option->get_description()) << "\n";
  for (const CLI::App* nested : app.get_subcommands(nullptr))
    Print(*nested, path + (path.empty() ? "" : " ") + nested->get_name());
}

}  // namespace

int main() {
  Print(*orient::MakeParser(orient::MakeCommands()), "");
  return std::cout.flush() ? 0 : 1;
}
