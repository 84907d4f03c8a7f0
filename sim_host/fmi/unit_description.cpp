// SPDX-License-Identifier: Apache-2.0
#include "unit_description.hpp"

#include <fmt/format.h>

#include <pugixml.hpp>
#include <sstream>

namespace trackservo::fmi {
namespace {

struct UnitDefinition {
  const char *name;
  int kg, m, s, A, rad;  // exponents of the base units
};

constexpr UnitDefinition kUnits[] = {
    {"s", 0, 0, 1, 0, 0},    {"rad", 0, 0, 0, 0, 1}, {"rad/s", 0, 0, -1, 0, 1}, {"rad/s2", 0, 0, -2, 0, 1},
    {"N.m", 1, 2, -2, 0, 0}, {"A", 0, 0, 0, 1, 0},   {"V", 1, 2, -3, -1, 0},
};

void add_units(pugi::xml_node root) {
  pugi::xml_node list = root.append_child("UnitDefinitions");
  for (const UnitDefinition& unit : kUnits) {
    pugi::xml_node node = list.append_child("Unit");
    node.append_attribute("name").set_value(unit.name);
    pugi::xml_node base = node.append_child("BaseUnit");
    const std::pair<const char *, int> exponents[] = {
        {"kg", unit.kg}, {"m", unit.m}, {"s", unit.s}, {"A", unit.A}, {"rad", unit.rad}};
    for (const auto& [name, exponent] : exponents) {
      if (exponent != 0) {
        base.append_attribute(name).set_value(exponent);
      }
    }
  }
}

void add_log_categories(pugi::xml_node root) {
  pugi::xml_node category = root.append_child("LogCategories").append_child("Category");
  category.append_attribute("name").set_value("logStatusError");
  category.append_attribute("description").set_value("Why a call was refused");
}

void add_experiment(pugi::xml_node root) {
  pugi::xml_node experiment = root.append_child("DefaultExperiment");
  experiment.append_attribute("startTime").set_value("0");
  experiment.append_attribute("stopTime").set_value("10");
  experiment.append_attribute("stepSize").set_value("0.001");
}

struct TypeAndStart {
  const char *type;
  std::string start;
};

TypeAndStart type_of(const Variable& variable) {
  struct Visit {
    TypeAndStart operator()(const double *value) const { return {"Float64", fmt::format("{}", *value)}; }
    TypeAndStart operator()(const std::uint64_t *value) const { return {"UInt64", fmt::format("{}", *value)}; }
    TypeAndStart operator()(const bool *value) const { return {"Boolean", *value ? "true" : "false"}; }
    TypeAndStart operator()(const std::string *value) const { return {"String", *value}; }
  };
  return std::visit(Visit{}, variable.value);
}

const char *causality_name(Causality causality) {
  switch (causality) {
    case Causality::kParameter:
      return "parameter";
    case Causality::kInput:
      return "input";
    case Causality::kOutput:
    default:
      return "output";
  }
}

// The order of attributes is that of the standard's examples.
void add_variable(pugi::xml_node list, const Variable& variable, unsigned reference) {
  const TypeAndStart type = type_of(variable);
  const bool is_number = std::string_view(type.type) == "Float64";
  pugi::xml_node node = list.append_child(type.type);
  node.append_attribute("name").set_value(variable.name.c_str());
  node.append_attribute("valueReference").set_value(reference);
  node.append_attribute("description").set_value(variable.description.c_str());
  node.append_attribute("causality").set_value(causality_name(variable.causality));
  if (variable.causality == Causality::kParameter) {
    node.append_attribute("variability").set_value("fixed");
  } else {
    node.append_attribute("variability").set_value(is_number ? "continuous" : "discrete");
  }
  if (!variable.unit.empty()) {
    node.append_attribute("unit").set_value(variable.unit.c_str());
  }
  if (variable.bound > 0.0) {
    node.append_attribute("min").set_value(-variable.bound);
    node.append_attribute("max").set_value(variable.bound);
  }
  if (variable.causality == Causality::kOutput) {
    return;
  }
  if (std::string_view(type.type) == "String") {
    node.append_child("Start").append_attribute("value").set_value(type.start.c_str());
  } else {
    node.append_attribute("start").set_value(type.start.c_str());
  }
}

void add_variables(pugi::xml_node root, const std::vector<Variable>& variables) {
  pugi::xml_node list = root.append_child("ModelVariables");
  pugi::xml_node time = list.append_child("Float64");
  time.append_attribute("name").set_value("time");
  time.append_attribute("valueReference").set_value(kTimeReference);
  time.append_attribute("description").set_value("Time of the simulation");
  time.append_attribute("causality").set_value("independent");
  time.append_attribute("variability").set_value("continuous");
  time.append_attribute("unit").set_value("s");
  for (std::size_t i = 0; i < variables.size(); ++i) {
    add_variable(list, variables[i], kFirstReference + static_cast<unsigned>(i));
  }
}

// An output changes in a step only, so that it depends on no input; at the beginning it depends on the parameters.
void add_structure(pugi::xml_node root, const std::vector<Variable>& variables) {
  std::string parameters;
  for (std::size_t i = 0; i < variables.size(); ++i) {
    if (variables[i].causality == Causality::kParameter) {
      parameters += fmt::format("{}{}", parameters.empty() ? "" : " ", kFirstReference + i);
    }
  }
  pugi::xml_node structure = root.append_child("ModelStructure");
  const std::pair<const char *, std::string> elements[] = {{"Output", ""}, {"InitialUnknown", parameters}};
  for (const auto& [element, dependencies] : elements) {
    for (std::size_t i = 0; i < variables.size(); ++i) {
      if (variables[i].causality == Causality::kOutput) {
        pugi::xml_node node = structure.append_child(element);
        node.append_attribute("valueReference").set_value(kFirstReference + static_cast<unsigned>(i));
        node.append_attribute("dependencies").set_value(dependencies.c_str());
      }
    }
  }
}

}  // namespace

std::string model_description(const Unit& unit) {
  const UnitKind kind = unit_kind();
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version").set_value("1.0");
  declaration.append_attribute("encoding").set_value("UTF-8");
  pugi::xml_node root = document.append_child("fmiModelDescription");
  const std::pair<const char *, std::string> attributes[] = {{"fmiVersion", "3.0"},
                                                             {"modelName", kind.name},
                                                             {"instantiationToken", instantiation_token(unit)},
                                                             {"description", kind.description},
                                                             {"version", TRACKSERVO_VERSION},
                                                             {"license", "Apache-2.0"},
                                                             {"generationTool", "trackservo " TRACKSERVO_VERSION},
                                                             {"variableNamingConvention", "structured"}};
  for (const auto& [name, value] : attributes) {
    root.append_attribute(name).set_value(value.c_str());
  }
  pugi::xml_node simulation = root.append_child("CoSimulation");
  simulation.append_attribute("modelIdentifier").set_value(kind.name);
  simulation.append_attribute("canHandleVariableCommunicationStepSize").set_value("true");
  simulation.append_attribute("fixedInternalStepSize").set_value("5e-05");
  add_units(root);
  add_log_categories(root);
  add_experiment(root);
  add_variables(root, unit.variables());
  add_structure(root, unit.variables());
  std::ostringstream text;
  document.save(text, "  ");
  return text.str();
}

}  // namespace trackservo::fmi
