#include "core/files/exchange/xml_elements.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "core/error.h"
#include "core/files/atomic_write.h"
#include "core/files/exchange/text_lines.h"

namespace orient {
namespace {

constexpr std::array<std::pair<const char*, char>, 5> kEntities = {
    {{"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}}};

std::string Trimmed(const std::string& text) {
  const char* blank = " \t\r\n";
  const auto first = text.find_first_not_of(blank);
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

std::string Unescaped(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto entity = std::find_if(kEntities.begin(), kEntities.end(), [&](const auto& e) {
      return text.compare(i, std::char_traits<char>::length(e.first), e.first) == 0;
    });
    if (text[i] != '&' || entity == kEntities.end()) {
      result += text[i];
    } else {
      result += entity->second;
      i += std::char_traits<char>::length(entity->first) - 1;
    }
  }
  return result;
}

class XmlText {
 public:
  XmlText(std::string file, std::string text) : file_(std::move(file)), text_(std::move(text)) {}

  XmlElement Root() {
    SkipToElement();
    XmlElement root = Element(0);
    return root;
  }

 private:
  [[noreturn]] void Fail(const std::string& complaint) const {
    const auto end = text_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, text_.size()));
    throw InputError(file_ + ", line " + std::to_string(1 + std::count(text_.begin(), end, '\n')) +
                     ": " + complaint);
  }
  // Counted on from the last time: elements begin one after another.
  int Line() {
    const auto from = text_.begin() + static_cast<std::ptrdiff_t>(counted_);
    const auto end = text_.begin() + static_cast<std::ptrdiff_t>(at_);
    line_ += static_cast<int>(std::count(from, end, '\n'));
    counted_ = at_;
    return line_;
  }
  bool Next(const std::string& word) const { return text_.compare(at_, word.size(), word) == 0; }

  void SkipPast(const std::string& word) {
    const auto found = text_.find(word, at_);
    if (found == std::string::npos) Fail("the file ends before \"" + word + "\"");
    at_ = found + word.size();
  }
  // Declarations and comments.
  bool SkipAside() {
    if (Next("<!--")) {
      SkipPast("-->");
    } else if (Next("<?")) {
      SkipPast("?>");
    } else if (Next("<!")) {
      SkipPast(">");
    } else {
      return false;
    }
    return true;
  }
  void SkipToElement() {
    for (;;) {
      at_ = text_.find('<', at_);
      if (at_ == std::string::npos) {
        at_ = text_.size();
        Fail("this is no XML: it holds no element");
      }
      if (!SkipAside()) return;
    }
  }
  void SkipBlanks() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }
  std::string Name() {
    const auto end = text_.find_first_of(" \t\r\n=/><\"", at_);
    if (end == std::string::npos || end == at_) Fail("a name is missing");
    std::string name = text_.substr(at_, end - at_);
    at_ = end;
    return name;
  }
  void Attributes(XmlElement* element) {
    for (SkipBlanks(); at_ < text_.size() && text_[at_] != '>' && text_[at_] != '/'; SkipBlanks()) {
      const std::string key = Name();
      SkipBlanks();
      if (!Next("=")) Fail("the attribute " + key + " has no value");
      ++at_;
      SkipBlanks();
      if (at_ >= text_.size() || (text_[at_] != '"' && text_[at_] != '\''))
        Fail("the value of " + key + " is not quoted");
      const auto end = text_.find(text_[at_], at_ + 1);
      if (end == std::string::npos) Fail("the value of " + key + " never ends");
      element->attributes[key] = Unescaped(text_.substr(at_ + 1, end - at_ - 1));
      at_ = end + 1;
    }
  }
  XmlElement Element(int depth) {
    constexpr int kDeepest = 100;
    if (depth > kDeepest) Fail("the elements are nested too deep");
    XmlElement element;
    element.file = file_;
    element.line = Line();
    ++at_;  // '<'
    element.name = Name();
    Attributes(&element);
    if (Next("/>")) {
      at_ += 2;
      return element;
    }
    if (!Next(">")) Fail("the element " + element.name + " is not closed");
    ++at_;
    Content(depth, &element);
    return element;
  }
  void Content(int depth, XmlElement* element) {
    std::string text;
    for (;;) {
      const auto next = text_.find('<', at_);
      if (next == std::string::npos) Fail("the element " + element->name + " never ends");
      text += text_.substr(at_, next - at_);
      at_ = next;
      if (SkipAside()) continue;
      if (!Next("</")) {
        element->children.push_back(Element(depth + 1));
        continue;
      }
      at_ += 2;
      const std::string closed = Name();
      if (closed != element->name) Fail("</" + closed + "> closes <" + element->name + ">");
      SkipPast(">");
      element->text = Unescaped(Trimmed(text));
      return;
    }
  }

  std::string file_, text_;
  std::size_t at_ = 0, counted_ = 0;
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
  if (found == nullptr) throw InputError(Where() + " lacks the element <" + child + ">");
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
  std::vector<double> numbers = ParseNumbers(text, file + ", line " + std::to_string(line), name);
  if (numbers.size() != count)
    throw InputError(Where() + " is \"" + text.substr(0, 60) + "\"; it must be " +
                     std::to_string(count) + (count == 1 ? " number" : " numbers"));
  return numbers;
}

std::string XmlElement::Where() const {
  return file + ", line " + std::to_string(line) + ": " + name;
}

XmlElement ReadXml(const std::string& path) { return XmlText(path, ReadFile(path)).Root(); }

std::string XmlEscaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    const auto entity = std::find_if(kEntities.begin(), kEntities.end(),
                                     [&](const auto& e) { return e.second == c; });
    if (entity == kEntities.end()) {
      escaped += c;
    } else {
      escaped += entity->first;
    }
  }
  return escaped;
}

}  // namespace orient
