"""The list of devices."""

import json

from command import DEVICE, CommandTest

KEYS = {
    "name", "platform", "driver", "type", "selector", "opencl_version", "compute_units", "max_work_group_size",
    "work_items_at_once", "global_memory_bytes", "max_allocation_bytes", "local_memory_bytes", "unified_memory", "fp64",
    "chosen"}


class Devices(CommandTest):
    def listed(self, **settings):
        return json.loads(self.succeed("devices", "--json", **settings))

    def test_json(self):
        listed = self.listed()
        self.assertGreater(len(listed["devices"]), 0)
        for device in listed["devices"]:
            self.assertEqual(set(device), KEYS)
            self.assertEqual(
                device["work_items_at_once"], device["compute_units"] * device["max_work_group_size"])
            self.assertGreater(device["work_items_at_once"], 0)
            self.assertGreater(device["global_memory_bytes"], 0)
        chosen = [device["selector"] for device in listed["devices"] if device["chosen"]]
        self.assertEqual(chosen, [listed["chosen"]])

    def test_the_environment_chooses(self):
        for device in self.listed()["devices"]:
            listed = self.listed(environment={"PCL_GPU_ICP_DEVICE": device["selector"]})
            self.assertEqual(listed["chosen"], device["selector"])

    def test_text(self):
        text = self.succeed("devices")
        for device in self.listed()["devices"]:
            for word in (device["selector"], device["name"], device["platform"], device["driver"],
                         f"{device['work_items_at_once']} work-items at once"):
                self.assertIn(word, text)
        self.assertEqual(text.count("[chosen]"), 1)

    def test_a_choice_that_matches_nothing(self):
        done = self.fail_with(DEVICE, "devices", environment={"PCL_GPU_ICP_DEVICE": "nosuch"}, names="nosuch")
        self.assertNotIn("[chosen]", done.stdout)
        self.assertIn("0:0", done.stdout)

    def test_no_opencl_at_all(self):
        self.fail_with(DEVICE, "devices", environment={"OCL_ICD_VENDORS": self.path("")}, names="pocl-opencl-icd")
