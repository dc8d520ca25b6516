// The little of XML that photogrammetric exchange files use: elements, attributes and text, each
// element knowing where it stands. pugixml parses. Private to core/exchange.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace orient {

// An element knowing the file and line where it stands.
struct XmlElement {
  std::string name;
  std::map<std::string, std::string> attributes;
  std::string text;  // of the element itself, trimmed
  std::vector<XmlElement> children;
  std::string file;
  int line = 0;

  const XmlElement* Find(const std::string& child) const;  // the first; null where absent
  const XmlElement& At(const std::string& child) const;    // throws InputError naming it
  std::vector<const XmlElement*> All(const std::string& child) const;
  // The first element of this name anywhere below, in document order; null where absent.
  const XmlElement* Below(const std::string& descendant) const;
  const std::string& Attribute(const std::string& key) const;
  double Number() const;                                 // of the text
  std::vector<double> Numbers(std::size_t count) const;  // of the text, exactly so many
  std::string Where() const;                             // "<file>, line <n>: <name>"
};

// The document's root. Throws InputError naming file and line.
XmlElement ReadXml(const std::string& path);
// For text and for values of attributes.
std::string XmlEscaped(const std::string& text);

}  // namespace orient
