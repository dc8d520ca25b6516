<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>
<qgis version="3.22" styleCategories="Symbology">
 <renderer-v2 type="categorizedSymbol" attr="state" symbollevels="0" enableorderby="0" forceraster="0">
  <categories>
   <category symbol="0" value="matched" label="matched" render="true"/>
   <category symbol="1" value="used" label="used" render="true"/>
   <category symbol="2" value="rejected" label="rejected" render="true"/>
   <category symbol="3" value="" label="other" render="true"/>
  </categories>
  <symbols>
   <symbol type="line" name="0" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="ArrowLine" enabled="1" locked="0" pass="0">
     <Option type="Map">
      <Option type="QString" name="arrow_width" value="0.3"/>
      <Option type="QString" name="arrow_start_width" value="0.3"/>
      <Option type="QString" name="head_length" value="1.2"/>
      <Option type="QString" name="head_thickness" value="0.8"/>
      <Option type="QString" name="head_type" value="0"/>
      <Option type="QString" name="arrow_type" value="0"/>
      <Option type="QString" name="is_curved" value="0"/>
      <Option type="QString" name="is_repeated" value="0"/>
     </Option>
     <symbol type="fill" name="@0@0" alpha="1">
      <layer class="SimpleFill" enabled="1" pass="0">
       <Option type="Map">
        <Option type="QString" name="color" value="31,98,173,255"/>
        <Option type="QString" name="outline_style" value="no"/>
        <Option type="QString" name="style" value="solid"/>
       </Option>
      </layer>
     </symbol>
    </layer>
   </symbol>
   <symbol type="line" name="1" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="ArrowLine" enabled="1" locked="0" pass="0">
     <Option type="Map">
      <Option type="QString" name="arrow_width" value="0.3"/>
      <Option type="QString" name="arrow_start_width" value="0.3"/>
      <Option type="QString" name="head_length" value="1.2"/>
      <Option type="QString" name="head_thickness" value="0.8"/>
      <Option type="QString" name="head_type" value="0"/>
      <Option type="QString" name="arrow_type" value="0"/>
      <Option type="QString" name="is_curved" value="0"/>
      <Option type="QString" name="is_repeated" value="0"/>
     </Option>
     <symbol type="fill" name="@1@0" alpha="1">
      <layer class="SimpleFill" enabled="1" pass="0">
       <Option type="Map">
        <Option type="QString" name="color" value="44,122,87,255"/>
        <Option type="QString" name="outline_style" value="no"/>
        <Option type="QString" name="style" value="solid"/>
       </Option>
      </layer>
     </symbol>
    </layer>
   </symbol>
   <symbol type="line" name="2" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="ArrowLine" enabled="1" locked="0" pass="0">
     <Option type="Map">
      <Option type="QString" name="arrow_width" value="0.3"/>
      <Option type="QString" name="arrow_start_width" value="0.3"/>
      <Option type="QString" name="head_length" value="1.2"/>
      <Option type="QString" name="head_thickness" value="0.8"/>
      <Option type="QString" name="head_type" value="0"/>
      <Option type="QString" name="arrow_type" value="0"/>
      <Option type="QString" name="is_curved" value="0"/>
      <Option type="QString" name="is_repeated" value="0"/>
     </Option>
     <symbol type="fill" name="@2@0" alpha="1">
      <layer class="SimpleFill" enabled="1" pass="0">
       <Option type="Map">
        <Option type="QString" name="color" value="192,45,134,255"/>
        <Option type="QString" name="outline_style" value="no"/>
        <Option type="QString" name="style" value="solid"/>
       </Option>
      </layer>
     </symbol>
    </layer>
   </symbol>
   <symbol type="line" name="3" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="ArrowLine" enabled="1" locked="0" pass="0">
     <Option type="Map">
      <Option type="QString" name="arrow_width" value="0.3"/>
      <Option type="QString" name="arrow_start_width" value="0.3"/>
      <Option type="QString" name="head_length" value="1.2"/>
      <Option type="QString" name="head_thickness" value="0.8"/>
      <Option type="QString" name="head_type" value="0"/>
      <Option type="QString" name="arrow_type" value="0"/>
      <Option type="QString" name="is_curved" value="0"/>
      <Option type="QString" name="is_repeated" value="0"/>
     </Option>
     <symbol type="fill" name="@3@0" alpha="1">
      <layer class="SimpleFill" enabled="1" pass="0">
       <Option type="Map">
        <Option type="QString" name="color" value="141,151,163,255"/>
        <Option type="QString" name="outline_style" value="no"/>
        <Option type="QString" name="style" value="solid"/>
       </Option>
      </layer>
     </symbol>
    </layer>
   </symbol>
  </symbols>
 </renderer-v2>
</qgis>
