// plugin_host PLUGIN: a program that knows nothing of PCL, loads a plugin, uses it and unloads it, again and again.
#include <dlfcn.h>
#include <stdio.h>

int main(int argc, char** argv)
{
  if (argc != 2)
    return 2;
  for (int time = 0; time < 3; ++time) {
    void* plugin = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    if (!plugin) {
      fprintf(stderr, "%s\n", dlerror());
      return 1;
    }
    int (*aligns)(void) = (int (*)(void))dlsym(plugin, "plugin_aligns");
    if (!aligns || !aligns()) {
      fprintf(stderr, "the plugin does not align the %d. time\n", time + 1);
      return 1;
    }
    if (dlclose(plugin) != 0)
      return 1;
  }
  return 0;
}
