"""KUKA's Robot Sensor Interface.

In: settings, the configuration of the controller.
Out: the driver.
"""
