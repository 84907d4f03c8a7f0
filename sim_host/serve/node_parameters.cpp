#include "serve/node_parameters.hpp"

#include "experiments/control_design.hpp"

namespace trackservo::sim {

axis_parameters node_parameters(const PlantConfig& plant, int axis) {
  DesignOptions options;
  options.tracker = TRACKER_PREDICTIVE;
  const ControllerSpec& spec = controller_spec("pi_vob_ftc");
  design_controller(plant, spec, options);  // refuses what is unstable
  return design_axis(plant, axis, spec, options);
}

}  // namespace trackservo::sim
