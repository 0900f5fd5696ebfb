// Visibility of a stream that arrives: chunks in order, each with the meshes and the calibration of its
// frame.
#pragma once

#include "fvv/frames.h"
#include "source.h"
#include "values.h"

#include <map>
#include <memory>
#include <vector>

namespace fvv::python {

using Meshes = std::map<uint16_t, std::shared_ptr<Mesh>>; // by track
// Weights of the vertices of a mesh, by mesh track and camera.
using Weights = std::map<std::pair<uint16_t, uint16_t>, std::vector<uint8_t>>;

class LiveVisibility {
public:
  LiveVisibility(const fvv_configuration &the_configuration, const Limits &the_limits,
                 const std::string &file_name)
      : configuration(the_configuration), limits(the_limits), file(file_name) {}
  void begin_group() { tracks.clear(); }
  // Adds what the cameras of a VISI chunk see; a mesh track and camera that are there already stay. meshes,
  // calibration: of the frame. Throws Failure.
  void decode(const fvv_frame_chunk &chunk, const Meshes &meshes, const fvv_calibration *calibration,
              Weights &out);

private:
  struct CloseOrder {
    void operator()(fvv_visibility_order *order) const { fvv_visibility_order_close(order); }
  };
  struct Track {
    fvv_visibility_header header = {};
    std::map<uint16_t, std::vector<uint8_t>> states; // by camera, of the chunk before
    std::unique_ptr<fvv_visibility_order, CloseOrder> order;
    std::vector<uint32_t> faces; // of order
  };
  void call(fvv_status status, fvv_diagnostic &diagnostic, const fvv_frame_chunk &chunk) const;
  [[noreturn]] void reject(uint32_t issue, const std::string &message, const fvv_frame_chunk &chunk) const;
  void check_number(const Track &track, const fvv_visibility_header &header,
                    const fvv_frame_chunk &chunk) const;
  void keep_order(Track &track, const fvv_mesh &mesh, const fvv_frame_chunk &chunk) const;
  void centre_of(uint16_t id, const fvv_calibration *calibration, int32_t centre[3],
                 const fvv_frame_chunk &chunk) const;

  const fvv_configuration &configuration;
  const Limits &limits;
  const std::string &file;
  std::map<uint16_t, Track> tracks;
};

} // namespace fvv::python
