#include "core/exchange/xml_elements.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <pugixml.hpp>
#include <utility>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/trimmed.h"
#include "core/exchange/text_lines.h"

namespace orient {
namespace {

// The elements of a file, each with its line. A document type declaration is skipped and everything
// in it ignored: only the five predefined entities and character references are resolved.
class XmlFile {
 public:
  explicit XmlFile(const std::string& path) : file_(path), text_(ReadFile(path)) {
    // Parsed as UTF-8 whatever encoding the file declares, so that offsets are those of the file.
    const pugi::xml_parse_result parsed =
        document_.load_buffer(text_.data(), text_.size(), pugi::parse_default, pugi::encoding_utf8);
    if (!parsed) Fail(static_cast<std::size_t>(parsed.offset), Complaint(parsed));
  }

  XmlElement Root() { return Element(document_.document_element(), 0); }

 private:
  [[noreturn]] void Fail(std::size_t at, const std::string& complaint) const {
    const auto end = text_.begin() + static_cast<std::ptrdiff_t>(std::min(at, text_.size()));
    throw InputError(
        fmt::format("{}, line {}: {}", file_, 1 + std::count(text_.begin(), end, '\n'), complaint));
  }

  std::string Complaint(const pugi::xml_parse_result& parsed) const {
    const auto at = static_cast<std::size_t>(parsed.offset);
    if (parsed.status == pugi::status_no_document_element)
      return "this is no XML: it holds no element";
    if (parsed.status == pugi::status_end_element_mismatch && at + 1 >= text_.size())
      return fmt::format("the element {} never ends", document_.document_element().name());
    const auto tag = std::min(text_.rfind('<', at), text_.size());
    const auto length = std::min<std::size_t>(text_.find('>', tag), tag + 60) + 1 - tag;
    return fmt::format("this is no XML: {} at \"{}\"", parsed.description(),
                       text_.substr(tag, length));
  }

  XmlElement Element(const pugi::xml_node& node, int depth) {
    constexpr int kDeepest = 100;
    const auto at = static_cast<std::size_t>(node.offset_debug());
    if (depth > kDeepest) Fail(at, "the elements are nested too deep");
    XmlElement element;
    element.file = file_;
    element.line = Line(at);
    element.name = node.name();
    for (const pugi::xml_attribute& attribute : node.attributes())
      element.attributes[attribute.name()] = attribute.value();
    std::string text;
    for (const pugi::xml_node& child : node.children()) {
      if (child.type() == pugi::node_element)
        element.children.push_back(Element(child, depth + 1));
      else
        text += child.value();
    }
    element.text = Trimmed(text);
    return element;
  }

  // Counts on from the previous call: elements come in the order of the file.
  int Line(std::size_t at) {
    const auto place = [&](std::size_t i) {
      return text_.begin() + static_cast<std::ptrdiff_t>(i);
    };
    line_ += static_cast<int>(std::count(place(counted_), place(at), '\n'));
    counted_ = at;
    return line_;
  }

  std::string file_, text_;
  pugi::xml_document document_;
  std::size_t counted_ = 0;
  int line_ = 1;
};

}  // namespace

const XmlElement* XmlElement::Find(const std::string& child) const {
  const auto found = std::find_if(children.begin(), children.end(),
                                  [&](const XmlElement& c) { return c.name == child; });
  return found == children.end() ? nullptr : &*found;
}

const XmlElement& XmlElement::At(const std::string& child) const {
  const XmlElement* found = Find(child);
  if (found == nullptr) throw InputError(fmt::format("{} lacks the element <{}>", Where(), child));
  return *found;
}

std::vector<const XmlElement*> XmlElement::All(const std::string& child) const {
  std::vector<const XmlElement*> found;
  for (const XmlElement& c : children)
    if (c.name == child) found.push_back(&c);
  return found;
}

const XmlElement* XmlElement::Below(const std::string& descendant) const {
  for (const XmlElement& c : children) {
    if (c.name == descendant) return &c;
    if (const XmlElement* found = c.Below(descendant)) return found;
  }
  return nullptr;
}

const std::string& XmlElement::Attribute(const std::string& key) const {
  const auto found = attributes.find(key);
  if (found == attributes.end()) throw InputError(Where() + " lacks the attribute " + key);
  return found->second;
}

double XmlElement::Number() const { return Numbers(1).front(); }

std::vector<double> XmlElement::Numbers(std::size_t count) const {
  std::vector<double> numbers = ParseNumbers(text, fmt::format("{}, line {}", file, line), name);
  if (numbers.size() != count)
    throw InputError(fmt::format("{} is \"{}\"; it must be {} {}", Where(), text.substr(0, 60),
                                 count, count == 1 ? "number" : "numbers"));
  return numbers;
}

std::string XmlElement::Where() const { return fmt::format("{}, line {}: {}", file, line, name); }

XmlElement ReadXml(const std::string& path) { return XmlFile(path).Root(); }

std::string XmlEscaped(const std::string& text) {
  constexpr std::array<std::pair<char, const char*>, 5> kEntities = {
      {{'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&apos;"}, {'&', "&amp;"}}};
  std::string escaped;
  for (const char c : text) {
    const auto entity = std::find_if(kEntities.begin(), kEntities.end(),
                                     [&](const auto& e) { return e.first == c; });
    escaped += entity == kEntities.end() ? std::string(1, c) : entity->second;
  }
  return escaped;
}

}  // namespace orient
