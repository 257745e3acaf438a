# Gives what links with TARGET the libraries of PCL that the plugin's templates call, and PCL's headers.
# PCL's own CMake targets name VTK and Qt as well: every program would load them when it starts, and a project that does
# not enable the language C could not be generated.
function(pcl_gpu_icp_use_pcl target)
  foreach(component COMMON KDTREE OCTREE SEARCH SAMPLE_CONSENSUS FILTERS FEATURES REGISTRATION)
    target_link_libraries(${target} INTERFACE ${PCL_${component}_LIBRARY})
  endforeach()
  target_link_libraries(${target} INTERFACE FLANN::FLANN)
  target_include_directories(${target} SYSTEM INTERFACE ${PCL_INCLUDE_DIRS})
endfunction()
