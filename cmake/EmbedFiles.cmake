# Writes OUTPUT, a C++ header with the text of every file in FILES, in the namespace pcl_gpu_icp::NAMESPACE:
# cmake -DOUTPUT=... -DNAMESPACE=... "-DFILES=a.cl;b.h" -P this.
set(content "// Generated. Do not edit.\n#pragma once\n\nnamespace pcl_gpu_icp::${NAMESPACE} {\n\n")
string(APPEND content "struct EmbeddedFile {\n  const char* name;\n  const char* text;\n};\n\n")
string(APPEND content "inline constexpr EmbeddedFile embedded_files[] = {\n")
foreach(file IN LISTS FILES)
  get_filename_component(name "${file}" NAME)
  file(READ "${file}" text)
  string(APPEND content "{\"${name}\", R\"EMBEDDED(${text})EMBEDDED\"},\n")
endforeach()
string(APPEND content "};\n\n} // namespace pcl_gpu_icp::${NAMESPACE}\n")
file(WRITE "${OUTPUT}" "${content}")
